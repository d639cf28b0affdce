"""Readers and writers of volumes, one module per format.

`read_volume` tells the format from the content, checks the header against limits before it loads anything, and gives
one scalar volume in RAS mm.
"""

from __future__ import annotations

from shapery_geometry.volume_io.nifti import write_nifti
from shapery_geometry.volume_io.reading import read_volume, read_volume_header
from shapery_geometry.volume_io.source import COMPONENTS, ReadLimits, VolumeHeader

__all__ = ["COMPONENTS", "ReadLimits", "VolumeHeader", "read_volume", "read_volume_header", "write_nifti"]
