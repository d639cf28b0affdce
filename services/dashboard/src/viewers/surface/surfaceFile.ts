/** A surface of a segmentation that is stored, and how it is shown. */
export interface SurfaceFile {
  id: number;
  url: string;
  size: number;
  color: string;
  /** The label of the voxels that it bounds. */
  label: number;
  /** What it belongs to; a group is shown, hidden and faded together. */
  group: string;
  title: string;
}
