import { seriesOf } from "@/features/preview/dicomFile";
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
  // By folder, and in it by what the files say: several series often lie together.
  const folders = new Map<string, Map<string, { name: string; files: ZipEntry[] }>>();
  for (const { path, file } of picked) {
    const folder = path.includes("/") ? path.slice(0, path.lastIndexOf("/")) : "";
    if (folder !== "" && LITTER.test(path)) {
      leftOut.push(path);
    } else if (await isDicom(file)) {
      const { uid, name } = readSeries(await file.slice(0, HEAD).arrayBuffer());
      const within = folders.get(folder) ?? new Map<string, { name: string; files: ZipEntry[] }>();
      const own = within.get(uid) ?? { name, files: [] };
      own.files.push({ path: path.slice(folder === "" ? 0 : folder.length + 1), content: file });
      folders.set(folder, within.set(uid, own));
    } else if (folder === "" || KNOWN.test(path)) {
      parcels.push({ type: "file", name: file.name, file });
    } else {
      leftOut.push(path);
    }
  }
  for (const [folder, series] of folders) {
    const names = new Set<string>();
    for (const { name, files } of series.values()) {
      const [only, ...others] = files;
      if (only && others.length === 0) {
        parcels.push({ type: "file", name: only.path, file: only.content as File });
        continue;
      }
      const place = folder === "" ? "series" : (folder.split("/").at(-1) ?? "series");
      const title = series.size > 1 && name ? `${place} ${name.replaceAll(/[^\p{L}\p{N}._-]+/gu, " ").trim()}` : place;
      let unlike = title;
      for (let number = 2; names.has(unlike); number += 1) unlike = `${title} ${number}`;
      names.add(unlike);
      parcels.push({ type: "archive", name: `${unlike}.zip`, files });
    }
  }
  return { parcels, leftOut };
}

/** Bytes in which a file says what series it is of. */
const HEAD = 65_536;

/** What cannot be read is left to the server, together with the rest of its folder. */
function readSeries(head: ArrayBuffer): { uid: string; name: string } {
  try {
    return seriesOf(head) ?? { uid: "", name: "" };
  } catch {
    return { uid: "", name: "" };
  }
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
