"""Resumable uploads: tus 1.0 with creation, creation-with-upload, deferred length, checksum, expiry, termination."""
