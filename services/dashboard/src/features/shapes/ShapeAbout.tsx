import {
  Badge,
  Button,
  Group,
  JsonInput,
  Paper,
  Select,
  Stack,
  TagsInput,
  Text,
  TextInput,
  Title,
} from "@mantine/core";

import { useQuery } from "@tanstack/react-query";
import { Pencil } from "lucide-react";
import { type SubmitEvent, useState } from "react";
import { collectionsQuery, labelsQuery, useUpdateShape } from "@/api/shapes";
import type { ShapeDetail } from "@/api/types";
import { Facts } from "@/app/Facts";
import { LinkAnchor } from "@/app/links";
import { Failure } from "@/app/Notice";
import { readLabel, readLabels, writeLabels } from "./labels";

/** What people say of a shape: name, collection, labels, metadata. */
export function ShapeAbout({ shape }: { shape: ShapeDetail }) {
  const [edits, setEdits] = useState(false);
  const labels = writeLabels(shape.labels);
  return (
    <Paper p="md" component="section" aria-labelledby="about">
      <Group justify="space-between" mb="xs">
        <Title order={2} id="about">
          About it
        </Title>
        {!edits && (
          <Button
            size="compact-sm"
            variant="default"
            leftSection={<Pencil size={13} aria-hidden="true" />}
            onClick={() => setEdits(true)}
          >
            Edit
          </Button>
        )}
      </Group>
      {edits ? (
        <Form shape={shape} onClose={() => setEdits(false)} />
      ) : (
        <Stack gap="sm">
          <Text size="sm">
            In{" "}
            <LinkAnchor to="/shapes" search={{ collection: shape.collection }} size="sm">
              {shape.collection}
            </LinkAnchor>
          </Text>
          {labels.length > 0 ? (
            <Group gap={6}>
              {labels.map((label) => (
                <LinkAnchor key={label} to="/shapes" search={{ labels: [label] }} underline="never">
                  <Badge variant="light" tt="none" fw={550} style={{ cursor: "pointer" }}>
                    {label}
                  </Badge>
                </LinkAnchor>
              ))}
            </Group>
          ) : (
            <Text size="sm" c="dimmed">
              No labels.
            </Text>
          )}
          {Object.keys(shape.metadata).length > 0 && (
            <Facts
              values="below"
              rows={Object.entries(shape.metadata).map(([name, value]) => [
                name,
                typeof value === "string" ? value : JSON.stringify(value),
              ])}
            />
          )}
        </Stack>
      )}
    </Paper>
  );
}

function Form({ shape, onClose }: { shape: ShapeDetail; onClose: () => void }) {
  const update = useUpdateShape();
  const collections = useQuery(collectionsQuery);
  const known = useQuery(labelsQuery(undefined));
  const [name, setName] = useState(shape.name);
  const [collection, setCollection] = useState(shape.collection);
  const [labels, setLabels] = useState(() => writeLabels(shape.labels));
  const [text, setText] = useState(() => JSON.stringify(shape.metadata, null, 2));
  const wrong = labels.find((label) => readLabel(label) === null);
  const metadata = readObject(text);
  const submit = (event: SubmitEvent) => {
    event.preventDefault();
    if (!metadata || wrong) return;
    update.mutate(
      { id: shape.id, change: { name: name.trim(), collection, labels: readLabels(labels), metadata } },
      { onSuccess: onClose },
    );
  };
  return (
    <form onSubmit={submit}>
      <Stack gap="sm">
        <TextInput
          label="Name"
          maxLength={255}
          data-autofocus
          value={name}
          onChange={(event) => setName(event.currentTarget.value)}
        />
        <Select
          label="Collection"
          data={[...new Set([shape.collection, ...(collections.data?.map((one) => one.name) ?? [])])]}
          allowDeselect={false}
          searchable
          value={collection}
          onChange={(value) => setCollection(value ?? shape.collection)}
        />
        <TagsInput
          label="Labels"
          description="As name:value; one value for each name."
          data={known.data?.map((label) => `${label.name}:${label.value}`) ?? []}
          value={labels}
          onChange={setLabels}
          error={wrong ? `“${wrong}” has no colon: write name:value.` : null}
        />
        <JsonInput
          label="Metadata"
          description="Anything that shall be kept with it, as JSON."
          autosize
          minRows={2}
          maxRows={12}
          value={text}
          onChange={setText}
          error={metadata ? null : "This is no JSON object."}
        />
        {update.isError && <Failure error={update.error} />}
        <Group justify="flex-end" gap="sm">
          <Button size="sm" variant="default" onClick={onClose}>
            Cancel
          </Button>
          <Button size="sm" type="submit" loading={update.isPending} disabled={!metadata || wrong !== undefined}>
            Save
          </Button>
        </Group>
      </Stack>
    </form>
  );
}

function readObject(text: string): Record<string, unknown> | null {
  if (text.trim() === "") return {};
  try {
    const value: unknown = JSON.parse(text);
    return typeof value === "object" && value !== null && !Array.isArray(value)
      ? (value as Record<string, unknown>)
      : null;
  } catch {
    return null;
  }
}
