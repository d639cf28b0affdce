"""Surfaces of tumors and vessels from volumes, by deformable meshes."""
