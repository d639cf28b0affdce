"""The ``.smc`` file: header, sections with checksums, connectivity, limits. See ``api_schema/smc.md``."""
