import { Button, Group, Text } from "@mantine/core";
import { FolderOpen, UploadCloud } from "lucide-react";
import { type DragEvent, useEffect, useRef, useState } from "react";
import { chosenFiles, droppedFiles, type Picked } from "./gather";
import classes from "./uploads.module.css";

interface DropAreaProps {
  onPicked: (picked: Picked[]) => void;
  title?: string;
  says?: string;
  limit?: string | undefined;
  /** Whether folders are taken as well as files. */
  folders?: boolean;
}

/** Takes files and folders, dropped or chosen with the keyboard. */
export function DropArea({
  onPicked,
  title = "Drop volumes here",
  says = "NIfTI, NRRD, MetaImage or DICOM: files, a zip, or a folder of slices. Meshes and mesh sequences, too.",
  limit,
  folders = true,
}: DropAreaProps) {
  const [over, setOver] = useState(false);
  const files = useRef<HTMLInputElement>(null);
  const folder = useRef<HTMLInputElement>(null);

  useEffect(() => {
    // A file that misses the area must not replace the page.
    const refuse = (event: globalThis.DragEvent) => event.preventDefault();
    window.addEventListener("dragover", refuse);
    window.addEventListener("drop", refuse);
    return () => {
      window.removeEventListener("dragover", refuse);
      window.removeEventListener("drop", refuse);
    };
  }, []);

  const drop = (event: DragEvent) => {
    event.preventDefault();
    setOver(false);
    void droppedFiles(event.dataTransfer).then(onPicked);
  };

  const choose = (input: HTMLInputElement) => {
    if (input.files) onPicked(chosenFiles(input.files));
    input.value = "";
  };

  return (
    <section
      className={classes.area}
      data-over={over || undefined}
      aria-label="Add files"
      onDragOver={(event) => {
        event.preventDefault();
        setOver(true);
      }}
      onDragLeave={(event) => {
        if (!event.currentTarget.contains(event.relatedTarget as Node | null)) setOver(false);
      }}
      onDrop={drop}
    >
      <UploadCloud size={30} strokeWidth={1.5} aria-hidden="true" className={classes.cloud} />
      <Text fw={600}>{title}</Text>
      <Text size="sm" c="dimmed" maw={440}>
        {says}
        {limit ? ` Up to ${limit} each.` : ""} An interrupted upload goes on where it stopped.
      </Text>
      <Group gap="xs" mt="sm" justify="center">
        <Button size="sm" onClick={() => files.current?.click()}>
          {folders ? "Choose files" : "Choose a file"}
        </Button>
        {folders && (
          <Button
            size="sm"
            variant="default"
            leftSection={<FolderOpen size={16} />}
            onClick={() => folder.current?.click()}
          >
            Choose a folder
          </Button>
        )}
      </Group>
      <input
        ref={files}
        type="file"
        multiple
        hidden
        data-testid="files"
        onChange={(event) => choose(event.currentTarget)}
      />
      <input
        ref={folder}
        type="file"
        hidden
        data-testid="folder"
        {...{ webkitdirectory: "" }}
        onChange={(event) => choose(event.currentTarget)}
      />
    </section>
  );
}
