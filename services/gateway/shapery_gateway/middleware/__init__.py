"""What happens to every request, outermost first: context, trust, limits, method override.

They are plain ASGI callables, since Starlette's `BaseHTTPMiddleware` breaks streaming and the detection of clients
that left.
"""
