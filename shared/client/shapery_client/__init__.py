"""Python SDK and the shapery command line."""
