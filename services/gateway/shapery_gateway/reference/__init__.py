"""The interface described: ``/openapi.json`` and ``/docs``."""
