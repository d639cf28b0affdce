import { Autocomplete, Button, Group, Modal, Stack, TagsInput, Text } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { useState } from "react";
import { infoQuery } from "@/api/queries";
import { collectionsQuery, labelsQuery } from "@/api/shapes";
import { sayFailure } from "@/app/say";
import { DropArea } from "@/features/uploads/DropArea";
import { gather, type Parcel, type Picked } from "@/features/uploads/gather";
import { bytes } from "@/format/format";
import { adding } from "./adder";
import { readLabel, readLabels } from "./labels";
import classes from "./shapes.module.css";

const SHOWN = 4;

interface AddShapesProps {
  /** What was dropped on the page; an empty list where the dialog was opened by its button, null while it is closed. */
  picked: readonly Picked[] | null;
  collection: string | undefined;
  onClose: () => void;
}

/** Asks which meshes, and where to put them. */
export function AddShapes({ picked, collection, onClose }: AddShapesProps) {
  return (
    <Modal opened={picked !== null} onClose={onClose} title="Add shapes" size="lg" centered>
      {picked && <Form first={picked} collection={collection} onClose={onClose} />}
    </Modal>
  );
}

function Form({ first, collection, onClose }: { first: readonly Picked[] } & Omit<AddShapesProps, "picked">) {
  const info = useQuery(infoQuery);
  const collections = useQuery(collectionsQuery);
  const known = useQuery(labelsQuery(undefined));
  const [files, setFiles] = useState(first);
  const [name, setName] = useState(collection ?? "");
  const [labels, setLabels] = useState<string[]>([]);
  const wrong = labels.find((label) => readLabel(label) === null);
  const into = name.trim() || "default";
  const add = async () => {
    let parcels: Parcel[];
    try {
      ({ parcels } = await gather(files));
    } catch (error) {
      sayFailure("The files could not be read", error);
      return;
    }
    onClose();
    await adding.add(parcels, into, readLabels(labels));
  };
  const size = files.reduce((sum, { file }) => sum + file.size, 0);
  return (
    <Stack gap="md" pt="xs">
      {files.length === 0 ? (
        <DropArea
          title="Drop meshes here"
          says="OBJ, PLY, STL, OFF or GLB: files or a folder."
          limit={info.data ? bytes(info.data.max_upload_bytes) : undefined}
          onPicked={setFiles}
        />
      ) : (
        <div className={classes.chosen}>
          <Text size="sm" fw={600}>
            {files.length === 1 ? "1 file" : `${files.length} files`}, {bytes(size)}
          </Text>
          <Text size="sm" c="dimmed" truncate>
            {files
              .slice(0, SHOWN)
              .map(({ file }) => file.name)
              .join(", ")}
            {files.length > SHOWN ? ", …" : ""}
          </Text>
          <Button size="compact-sm" variant="default" onClick={() => setFiles([])}>
            Choose others
          </Button>
        </div>
      )}
      <Autocomplete
        label="Collection"
        description="A name that is not there yet makes a new one."
        placeholder="default"
        data={collections.data?.map((one) => one.name) ?? []}
        maxLength={200}
        value={name}
        onChange={setName}
      />
      <TagsInput
        label="Labels"
        description="As name:value, for example side:left. All of these shapes will carry them."
        placeholder={labels.length === 0 ? "none" : ""}
        comboboxProps={{ position: "top-start" }}
        data={known.data?.map((label) => `${label.name}:${label.value}`) ?? []}
        value={labels}
        onChange={setLabels}
        error={wrong ? `“${wrong}” has no colon: write name:value.` : null}
      />
      <Group justify="flex-end">
        <Button variant="default" onClick={onClose}>
          Cancel
        </Button>
        <Button disabled={files.length === 0 || wrong !== undefined} onClick={() => void add()}>
          {files.length === 0 ? "Add" : files.length === 1 ? "Add the shape" : `Add ${files.length} shapes`}
        </Button>
      </Group>
    </Stack>
  );
}
