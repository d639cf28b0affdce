"""The HTTP gateway of Shapery: uploads, jobs, results and the dashboard over one FastAPI app."""

__version__ = "0.1.0"
