import type { ZipEntry } from "./zip";

/** A file with its place inside of what was dropped or chosen. */
export interface Picked {
  path: string;
  file: File;
}

/** One thing to upload: a file as it is, or several that travel as one archive. */
export type Parcel = { type: "file"; name: string; file: File } | { type: "archive"; name: string; files: ZipEntry[] };

export interface Gathered {
  parcels: Parcel[];
  /** Paths of files that are none of ours: they lay in a folder beside others. */
  leftOut: string[];
}

const LITTER = /(^|\/)(\.[^/]*|thumbs\.db|desktop\.ini|dicomdir|__macosx\/.*)$/i;
const KNOWN = /\.(nii|nii\.gz|nrrd|mha|dcm|ima|obj|ply|stl|off|glb|npz|zip|smc)$/i;

/** Decide what becomes an upload of its own and what belongs together: the slices of a DICOM series lie in many files. */
export async function gather(picked: readonly Picked[]): Promise<Gathered> {
  const parcels: Parcel[] = [];
  const leftOut: string[] = [];
  const series = new Map<string, ZipEntry[]>();
  for (const { path, file } of picked) {
    const folder = path.includes("/") ? path.slice(0, path.lastIndexOf("/")) : "";
    if (folder !== "" && LITTER.test(path)) {
      leftOut.push(path);
    } else if (await isDicom(file)) {
      const entries = series.get(folder) ?? [];
      entries.push({
        path: path.slice(folder === "" ? 0 : folder.length + 1),
        content: file,
      });
      series.set(folder, entries);
    } else if (folder === "" || KNOWN.test(path)) {
      parcels.push({ type: "file", name: file.name, file });
    } else {
      leftOut.push(path);
    }
  }
  for (const [folder, files] of series) {
    const [only, ...others] = files;
    if (only && others.length === 0) {
      parcels.push({
        type: "file",
        name: only.path,
        file: only.content as File,
      });
    } else {
      const name = folder === "" ? "series" : (folder.split("/").at(-1) ?? "series");
      parcels.push({ type: "archive", name: `${name}.zip`, files });
    }
  }
  return { parcels, leftOut };
}

/** DICOM part 10: 128 bytes of anything, then "DICM". */
async function isDicom(file: Blob): Promise<boolean> {
  if (file.size < 132) return false;
  const magic = new Uint8Array(await file.slice(128, 132).arrayBuffer());
  return magic[0] === 0x44 && magic[1] === 0x49 && magic[2] === 0x43 && magic[3] === 0x4d;
}

/** Everything in a drop, folders walked through. Entries must be taken before the event handler returns. */
export function droppedFiles(transfer: DataTransfer): Promise<Picked[]> {
  const entries = [...transfer.items]
    .filter((item) => item.kind === "file")
    .map((item) => item.webkitGetAsEntry())
    .filter((entry) => entry !== null);
  if (entries.length === 0) return Promise.resolve([...transfer.files].map((file) => ({ path: file.name, file })));
  return walk(entries, "");
}

async function walk(entries: readonly FileSystemEntry[], prefix: string): Promise<Picked[]> {
  const picked: Picked[] = [];
  for (const entry of entries) {
    const path = prefix + entry.name;
    if (entry.isDirectory) {
      picked.push(...(await walk(await children(entry as FileSystemDirectoryEntry), `${path}/`)));
    } else {
      const file = await new Promise<File>((resolve, reject) => (entry as FileSystemFileEntry).file(resolve, reject));
      picked.push({ path, file });
    }
  }
  return picked;
}

async function children(folder: FileSystemDirectoryEntry): Promise<FileSystemEntry[]> {
  const reader = folder.createReader();
  const all: FileSystemEntry[] = [];
  for (;;) {
    // Browsers hand out about a hundred entries at a time, and an empty list at the end.
    const some = await new Promise<FileSystemEntry[]>((resolve, reject) => reader.readEntries(resolve, reject));
    if (some.length === 0) return all;
    all.push(...some);
  }
}

/** What a file input holds; a folder's files carry their path. */
export function chosenFiles(files: FileList): Picked[] {
  return [...files].map((file) => ({
    path: file.webkitRelativePath || file.name,
    file,
  }));
}
