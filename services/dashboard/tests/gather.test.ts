import { expect, it } from "vitest";
import { gather } from "@/features/uploads/gather";

function file(name: string, content: string | Uint8Array<ArrayBuffer> = "x"): File {
  return new File([content], name);
}

function dicom(name: string): File {
  const bytes = new Uint8Array(200);
  bytes.set(new TextEncoder().encode("DICM"), 128);
  return file(name, bytes);
}

it("sends files that were chosen one by one as they are, whatever they are called", async () => {
  const picked = ["t1c.nii.gz", "notes.docx"].map((name) => ({
    path: name,
    file: file(name),
  }));
  const { parcels, leftOut } = await gather(picked);
  expect(parcels).toMatchObject([
    { type: "file", name: "t1c.nii.gz" },
    { type: "file", name: "notes.docx" }, // the server says what is wrong with it
  ]);
  expect(leftOut).toEqual([]);
});

it("puts the slices of each folder into one archive and leaves the rest of the folder out", async () => {
  const { parcels, leftOut } = await gather([
    { path: "study/t1/IM2", file: dicom("IM2") },
    { path: "study/t1/IM1", file: dicom("IM1") },
    { path: "study/t2/IM1", file: dicom("IM1") },
    { path: "study/t2/IM2", file: dicom("IM2") },
    { path: "study/DICOMDIR", file: dicom("DICOMDIR") },
    { path: "study/report.pdf", file: file("report.pdf") },
    { path: "study/.DS_Store", file: file(".DS_Store") },
    { path: "study/head.nii.gz", file: file("head.nii.gz") },
  ]);
  expect(parcels.map(({ type, name }) => `${type} ${name}`).sort()).toEqual([
    "archive t1.zip",
    "archive t2.zip",
    "file head.nii.gz",
  ]);
  const archive = parcels.find(({ name }) => name === "t1.zip");
  expect(archive?.type === "archive" && archive.files.map(({ path }) => path)).toEqual(["IM2", "IM1"]);
  expect(leftOut.sort()).toEqual(["study/.DS_Store", "study/DICOMDIR", "study/report.pdf"]);
});

it("takes several loose slices for one series, and a single one for a file", async () => {
  const loose = await gather([1, 2, 3].map((n) => ({ path: `IM${n}`, file: dicom(`IM${n}`) })));
  expect(loose.parcels).toMatchObject([{ type: "archive", name: "series.zip", files: { length: 3 } }]);
  const single = await gather([{ path: "enhanced.dcm", file: dicom("enhanced.dcm") }]);
  expect(single.parcels).toMatchObject([{ type: "file", name: "enhanced.dcm" }]);
});

it("is not misled by short files", async () => {
  const { parcels } = await gather([{ path: "tiny", file: file("tiny", "DICM") }]);
  expect(parcels).toMatchObject([{ type: "file" }]);
});
