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

it("parts the series that lie in one folder by what their files say", async () => {
  /** The beginning of a slice: types are told, as in nearly all files. */
  const slice = (uid: string, description: string) => {
    const element = (group: number, number: number, type: string, value: string) => {
      const even = value.length % 2 ? `${value} ` : value;
      return [new Uint8Array(Uint16Array.of(group, number).buffer), type, new Uint8Array([even.length, 0]), even];
    };
    return new File(
      [
        new Uint8Array(128),
        "DICM",
        ...element(2, 0x10, "UI", "1.2.840.10008.1.2.4.70"),
        ...element(8, 0x103e, "LO", description),
        ...element(0x20, 0x0e, "UI", uid),
      ],
      "IM",
    );
  };
  const series = [
    ["1.1", "T1/post"],
    ["1.2", "T1 post"],
    ["1.3", "scout"],
  ] as const;
  const picked = series.flatMap(([uid, name], index) =>
    [0, 1].map((k) => ({ path: `study/IM${2 * index + k}`, file: slice(uid, name) })),
  );
  const { parcels } = await gather(picked.slice(0, 5));
  expect(parcels.map(({ type, name }) => `${type} ${name}`)).toEqual([
    "archive study T1 post.zip",
    "archive study T1 post 2.zip",
    "file IM4",
  ]);
  const first = parcels[0];
  expect(first?.type === "archive" && first.files.map(({ path }) => path)).toEqual(["IM0", "IM1"]);
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
