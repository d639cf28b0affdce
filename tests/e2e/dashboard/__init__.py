"""The dashboard, in a real browser.

A package, so that fixtures of its scope (browser, platform) end with its last test: the browser's event loop runs as
long as the browser, and tests that start a loop of their own would find it running.
"""
