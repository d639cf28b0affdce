"""Settings, database, object storage, jobs and queue of the Shapery platform."""
