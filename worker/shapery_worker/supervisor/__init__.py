"""The whole platform as processes of one supervisor, on one machine: what ``shapery up`` runs."""
