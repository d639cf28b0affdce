import { Alert, Button, Paper, SegmentedControl, Select, Stack, Text, Title } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { getRouteApi, useNavigate } from "@tanstack/react-router";
import { Film, Upload } from "lucide-react";
import { type SubmitEvent, useState } from "react";
import { Attempts } from "@/api/idempotency";
import { assetsQuery, kindsQuery, useCreateJob } from "@/api/queries";
import type { Asset } from "@/api/types";
import { LinkButton } from "@/app/links";
import { Empty, Failure, Waiting } from "@/app/Notice";
import { Page } from "@/app/Page";
import { AsCode } from "@/features/snippets/AsCode";
import { jobSnippets } from "@/features/snippets/snippets";
import { describeAsset } from "@/format/asset";
import classes from "./motion.module.css";

const QUALITIES = [
  { value: "0.02", label: "Finest: KG error up to 0.02 %" },
  { value: "0.05", label: "Fine: up to 0.05 %" },
  { value: "0.1", label: "Good: up to 0.1 %" },
  { value: "0.5", label: "Small: up to 0.5 %" },
  { value: "1", label: "Smallest: up to 1 %" },
];

const route = getRouteApi("/motion");

/** Compresses a mesh sequence. */
export function MotionPage() {
  const sequences = useQuery(assetsQuery("sequence"));
  return (
    <Page
      title="Compress a motion"
      lead="A mesh sequence becomes one small file that plays in the browser. The error you ask for is met by the decoded file."
    >
      {sequences.isPending ? (
        <Waiting label="Loading the sequences…" />
      ) : sequences.isError && !sequences.data ? (
        <Failure error={sequences.error} onRetry={() => void sequences.refetch()} />
      ) : sequences.data.items.length === 0 ? (
        <Empty icon={<Film size={32} />} title="No mesh sequences yet">
          <Text c="dimmed" size="sm">
            Upload an npz with vertices and faces, or a zip of OBJ, PLY, OFF or STL frames of one connectivity.
          </Text>
          <LinkButton to="/upload" mt="sm" leftSection={<Upload size={16} aria-hidden="true" />}>
            Upload a sequence
          </LinkButton>
        </Empty>
      ) : (
        <EncodeForm sequences={sequences.data.items} />
      )}
    </Page>
  );
}

function EncodeForm({ sequences }: { sequences: readonly Asset[] }) {
  const { sequence: wanted } = route.useSearch();
  const navigate = useNavigate();
  const kinds = useQuery(kindsQuery);
  const create = useCreateJob();
  const [attempts] = useState(() => new Attempts());
  const [id, setId] = useState<string | null>(
    sequences.find((sequence) => sequence.id === wanted)?.id ?? sequences[0]?.id ?? null,
  );
  const [kg, setKg] = useState("0.1");
  const [preset, setPreset] = useState("default");
  const kind = kinds.data?.find(({ name }) => name === "motion-encode");
  const chosen = sequences.find((sequence) => sequence.id === id);
  const input = Object.entries(kind?.inputs ?? {}).find(([, spec]) => spec.required)?.[0];
  const request = {
    kind: "motion-encode",
    inputs: input && chosen ? { [input]: chosen.id } : {},
    params: { kg: Number(kg), ...(preset === "fast" ? { preset } : {}) },
  };
  const submit = (event: SubmitEvent) => {
    event.preventDefault();
    create.mutate(
      { request, idempotencyKey: attempts.keyFor(request) },
      { onSuccess: (job) => void navigate({ to: "/jobs/$jobId", params: { jobId: job.id } }) },
    );
  };
  return (
    <div className={classes.columns}>
      <Paper p="lg">
        <form onSubmit={submit}>
          <Stack gap="md">
            <Select
              label="Sequence"
              data={sequences.map((sequence) => ({ value: sequence.id, label: sequence.filename }))}
              description={chosen ? describeAsset(chosen) : undefined}
              searchable
              allowDeselect={false}
              value={id}
              onChange={setId}
            />
            <Select
              label="Quality"
              data={QUALITIES}
              allowDeselect={false}
              value={kg}
              onChange={(value) => setKg(value ?? "0.1")}
            />
            <div>
              <Text size="sm" fw={500} mb={4} id="preset">
                Take time for
              </Text>
              <SegmentedControl
                aria-labelledby="preset"
                data={[
                  { value: "default", label: "the smallest file" },
                  { value: "fast", label: "a quick result" },
                ]}
                value={preset}
                onChange={setPreset}
              />
            </div>
            {kind?.workers === 0 && (
              <Alert color="orange" variant="light">
                No worker for motions is running at the moment. The job will wait for one.
              </Alert>
            )}
            {create.isError && <Failure error={create.error} />}
            <Button type="submit" w="fit-content" disabled={!chosen || !input} loading={create.isPending}>
              Compress
            </Button>
          </Stack>
        </form>
      </Paper>
      <Stack gap="md">
        <Paper p="md">
          <Title order={3} mb={4}>
            How it is measured
          </Title>
          <Text size="sm" c="dimmed">
            The KG error compares all frames with the original, relative to how far their vertices lie from each frame’s
            center. At 0.1 % normals are off by about two degrees.
          </Text>
        </Paper>
        {chosen && <AsCode of={(target) => jobSnippets(request, target)} />}
      </Stack>
    </div>
  );
}
