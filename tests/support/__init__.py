"""Real servers for tests: PostgreSQL, S3 and Redis, on loopback and private ports, gone with the test run."""
