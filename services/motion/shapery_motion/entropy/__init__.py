"""Entropy coding: a binary range coder, adaptive probabilities, and their logistic mixing, all in integers."""
