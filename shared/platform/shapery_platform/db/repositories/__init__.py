"""Every query of the platform, one module per aggregate. They take a session and never commit."""
