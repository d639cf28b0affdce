import { ActionIcon, Button, Checkbox, Group, Menu, Modal, Stack, Text, TextInput } from "@mantine/core";
import { Link } from "@tanstack/react-router";
import { Ellipsis, Pencil, Plus, RotateCw, Trash2 } from "lucide-react";
import { type SubmitEvent, useState } from "react";
import { useCollectionAction } from "@/api/shapes";
import type { Collection } from "@/api/types";
import { Failure } from "@/app/Notice";
import { integer } from "@/format/format";
import classes from "./shapes.module.css";
import { useReindex } from "./useReindex";

type Asked = { is: "make" } | { is: "rename" | "remove"; of: Collection };

interface CollectionsProps {
  /** Undefined while they are not known. */
  collections: readonly Collection[] | undefined;
  chosen: string | undefined;
  /** Where the list goes when the chosen collection has another name, or is gone. */
  onChosen: (name: string | undefined) => void;
}

/** All collections; the chosen one can be renamed and deleted. */
export function Collections({ collections, chosen, onChosen }: CollectionsProps) {
  const [asked, setAsked] = useState<Asked | null>(null);
  const total = collections?.reduce((sum, { shapes }) => sum + shapes, 0);
  const close = () => setAsked(null);
  return (
    <nav className={classes.collections} aria-label="Collections">
      <Link
        from="/shapes"
        to="/shapes"
        search={(before) => ({ ...before, collection: undefined })}
        className={classes.collection}
        data-active={chosen === undefined || undefined}
        aria-current={chosen === undefined ? "page" : undefined}
      >
        <span className={classes.name}>All shapes</span>
        {total !== undefined && <span className={classes.number}>{integer(total)}</span>}
      </Link>
      {collections?.map((collection) => (
        <div key={collection.id} className={classes.entry}>
          <Link
            from="/shapes"
            to="/shapes"
            search={(before) => ({ ...before, collection: collection.name })}
            className={classes.collection}
            data-active={collection.name === chosen || undefined}
            aria-current={collection.name === chosen ? "page" : undefined}
          >
            <span className={classes.name} title={collection.name}>
              {collection.name}
            </span>
            <span className={classes.number}>{integer(collection.shapes)}</span>
          </Link>
          {collection.name === chosen && (
            <CollectionMenu collection={collection} onAsk={(is) => setAsked({ is, of: collection })} />
          )}
        </div>
      ))}
      <Button
        variant="subtle"
        color="gray"
        size="compact-sm"
        className={classes.make ?? ""}
        leftSection={<Plus size={14} aria-hidden="true" />}
        onClick={() => setAsked({ is: "make" })}
      >
        New collection
      </Button>
      <Modal
        opened={asked !== null}
        onClose={close}
        centered
        title={
          asked?.is === "make"
            ? "New collection"
            : asked?.is === "rename"
              ? "Rename the collection"
              : "Delete the collection"
        }
      >
        {asked?.is === "remove" ? (
          <Removal collection={asked.of} onClose={close} onDone={() => onChosen(undefined)} />
        ) : (
          asked && <Naming asked={asked} onClose={close} onDone={onChosen} />
        )}
      </Modal>
    </nav>
  );
}

function CollectionMenu({ collection, onAsk }: { collection: Collection; onAsk: (is: "rename" | "remove") => void }) {
  const { reindex } = useReindex();
  return (
    <Menu position="bottom-end" shadow="md">
      <Menu.Target>
        <ActionIcon variant="subtle" color="gray" size={28} aria-label={`Change the collection ${collection.name}`}>
          <Ellipsis size={16} />
        </ActionIcon>
      </Menu.Target>
      <Menu.Dropdown>
        <Menu.Item leftSection={<Pencil size={15} />} onClick={() => onAsk("rename")}>
          Rename
        </Menu.Item>
        {collection.outdated > 0 && (
          <Menu.Item leftSection={<RotateCw size={15} />} onClick={() => reindex([collection])}>
            Index {integer(collection.outdated)} outdated again
          </Menu.Item>
        )}
        <Menu.Item leftSection={<Trash2 size={15} />} color="red" onClick={() => onAsk("remove")}>
          Delete
        </Menu.Item>
      </Menu.Dropdown>
    </Menu>
  );
}

interface AnswerProps {
  onClose: () => void;
  onDone: (name: string) => void;
}

function Naming({ asked, onClose, onDone }: { asked: Asked } & AnswerProps) {
  const act = useCollectionAction();
  const [name, setName] = useState(asked.is === "make" ? "" : asked.of.name);
  const submit = (event: SubmitEvent) => {
    event.preventDefault();
    const to = name.trim();
    act.mutate(asked.is === "make" ? { make: to } : { rename: asked.of.id, to }, {
      onSuccess: () => {
        onClose();
        onDone(to);
      },
    });
  };
  return (
    <form onSubmit={submit}>
      <Stack gap="md">
        <TextInput
          label="Name"
          maxLength={200}
          data-autofocus
          value={name}
          onChange={(event) => setName(event.currentTarget.value)}
        />
        {act.isError && <Failure error={act.error} />}
        <Group justify="flex-end">
          <Button variant="default" onClick={onClose}>
            Cancel
          </Button>
          <Button type="submit" disabled={!name.trim()} loading={act.isPending}>
            {asked.is === "make" ? "Make it" : "Rename"}
          </Button>
        </Group>
      </Stack>
    </form>
  );
}

function Removal({
  collection,
  onClose,
  onDone,
}: { collection: Collection; onDone: () => void } & Pick<AnswerProps, "onClose">) {
  const act = useCollectionAction();
  const [sure, setSure] = useState(false);
  const { shapes } = collection;
  return (
    <Stack gap="md">
      <Text size="sm">
        {shapes === 0
          ? `“${collection.name}” is empty.`
          : `“${collection.name}” has ${shapes === 1 ? "one shape" : `${integer(shapes)} shapes`}. The meshes they were made of stay.`}
      </Text>
      {shapes > 0 && (
        <Checkbox
          label={shapes === 1 ? "Delete its shape, too" : "Delete its shapes, too"}
          checked={sure}
          onChange={(event) => setSure(event.currentTarget.checked)}
        />
      )}
      {act.isError && <Failure error={act.error} />}
      <Group justify="flex-end">
        <Button variant="default" onClick={onClose} data-autofocus>
          Cancel
        </Button>
        <Button
          color="red"
          disabled={shapes > 0 && !sure}
          loading={act.isPending}
          onClick={() =>
            act.mutate(
              { remove: collection.id, shapes: sure },
              {
                onSuccess: () => {
                  onClose();
                  onDone();
                },
              },
            )
          }
        >
          Delete
        </Button>
      </Group>
    </Stack>
  );
}
