import {
  Alert,
  Button,
  Collapse,
  type ComboboxItem,
  Paper,
  SegmentedControl,
  Select,
  Stack,
  Text,
  Title,
} from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { useNavigate, useSearch } from "@tanstack/react-router";
import { ChevronDown, ChevronRight } from "lucide-react";
import { type SubmitEvent, useMemo, useState } from "react";
import { Attempts } from "@/api/idempotency";
import { kindsQuery, useCreateJob, volumesQuery } from "@/api/queries";
import type { Asset, JobCreate } from "@/api/types";
import { Failure } from "@/app/Notice";
import { AsCode } from "@/features/snippets/AsCode";
import { jobSnippets } from "@/features/snippets/snippets";
import { describeAsset } from "@/format/asset";
import { AdvancedFields } from "./AdvancedFields";
import { type Choices, DEFAULTS, readChoices } from "./params";
import { guessRoles, type Roles } from "./roles";

const MODES: { value: Choices["mode"]; label: string }[] = [
  { value: "auto", label: "Automatic" },
  { value: "tumor", label: "Tumors" },
  { value: "object", label: "Any object" },
];

/** Starts a segmentation; `recent` are the assets just uploaded, which are most likely meant. */
export function SegmentForm({ recent }: { recent: readonly string[] }) {
  const navigate = useNavigate();
  const asked = useSearch({ from: "/upload" });
  const volumes = useQuery(volumesQuery);
  const kinds = useQuery(kindsQuery);
  const create = useCreateJob();
  const [chosen, setChosen] = useState<Partial<Roles>>({});
  const [open, setOpen] = useState(false);
  const [choices, setChoices] = useState(DEFAULTS);
  const set = (change: Partial<Choices>) => setChoices((before) => ({ ...before, ...change }));
  const [attempts] = useState(() => new Attempts());

  const all = volumes.data?.items ?? [];
  const guessed = useMemo(() => {
    const items = volumes.data?.items ?? [];
    const fresh = items.filter((volume) => recent.includes(volume.id));
    return fresh.length > 0
      ? guessRoles(fresh)
      : { post: asked.post ?? null, pre: asked.pre ?? null, vessels: asked.vessels ?? null };
  }, [volumes.data, recent, asked.post, asked.pre, asked.vessels]);
  const roles: Roles = { ...guessed, ...chosen };
  const known = (id: string | null) => (id && all.some((volume) => volume.id === id) ? id : null);
  const post = known(roles.post);
  const pre = choices.mode === "object" ? null : known(roles.pre);
  const vessels = known(roles.vessels);
  const { problems, params } = readChoices(choices, vessels !== null);
  const hindered = Object.keys(problems).length > 0;
  const kind = kinds.data?.find(({ name }) => name === "segmentation");

  const request: JobCreate = {
    kind: "segmentation",
    inputs: { post: post ?? "", ...(pre ? { pre } : {}), ...(vessels ? { vessels } : {}) },
    params,
  };
  const submit = (event: SubmitEvent) => {
    event.preventDefault();
    if (!post || hindered) return;
    create.mutate(
      { request, idempotencyKey: attempts.keyFor(request) },
      {
        onSuccess: (job) => void navigate({ to: "/jobs/$jobId", params: { jobId: job.id } }),
      },
    );
  };

  return (
    <Stack gap="md">
      <Paper p="lg" component="section" aria-labelledby="segment">
        <form onSubmit={submit}>
          <Stack gap="md">
            <div>
              <Title order={2} id="segment">
                Segment
              </Title>
              <Text size="sm" c="dimmed">
                Finds enhancing tumors, what they enclose, and the vessels around them; or any object you point at.
              </Text>
            </div>
            {kind && kind.workers === 0 && (
              <Alert color="orange" variant="light">
                No worker for segmentation is running at the moment. The job will wait for one.
              </Alert>
            )}
            <div>
              <Text size="sm" fw={500} mb={4} id="mode">
                What is looked for
              </Text>
              <SegmentedControl
                fullWidth
                size="sm"
                aria-labelledby="mode"
                data={MODES}
                value={choices.mode}
                onChange={(mode) => {
                  set({ mode });
                  if (mode === "object") setOpen(true);
                }}
              />
              {problems.mode && (
                <Text size="xs" c="red" mt={4} role="alert">
                  {problems.mode}
                </Text>
              )}
            </div>
            <VolumeSelect
              label={choices.mode === "object" ? "Volume" : "After contrast (T1c)"}
              required
              volumes={all.filter(({ id }) => id !== pre && id !== vessels)}
              value={post}
              known={volumes.data !== undefined}
              onChange={(id) => setChosen((before) => ({ ...before, post: id }))}
            />
            {choices.mode !== "object" && (
              <VolumeSelect
                label="Before contrast (T1)"
                description="Optional: with it, what was bright from the start is told from what takes up contrast."
                volumes={all.filter(({ id }) => id !== post && id !== vessels)}
                value={pre}
                known={volumes.data !== undefined}
                onChange={(id) => setChosen((before) => ({ ...before, pre: id }))}
              />
            )}
            <VolumeSelect
              label="Vessels (SWI, MRA, CTA)"
              description="Optional: vessels around what is found, and bleedings beside them."
              volumes={all.filter(({ id }) => id !== post && id !== pre)}
              value={vessels}
              known={volumes.data !== undefined}
              onChange={(id) => setChosen((before) => ({ ...before, vessels: id }))}
            />
            <div>
              <Button
                variant="subtle"
                color="gray"
                size="compact-sm"
                px={6}
                ml={-6}
                aria-expanded={open}
                aria-controls="advanced"
                leftSection={open ? <ChevronDown size={16} /> : <ChevronRight size={16} />}
                onClick={() => setOpen(!open)}
              >
                Details
              </Button>
              <Collapse expanded={open} id="advanced" pt={open ? "sm" : 0}>
                <AdvancedFields choices={choices} problems={problems} withVessels={vessels !== null} onChange={set} />
              </Collapse>
            </div>
            {create.isError && <Failure error={create.error} />}
            <Button type="submit" disabled={!post || hindered} loading={create.isPending}>
              Segment
            </Button>
          </Stack>
        </form>
      </Paper>
      {post && <AsCode of={(target) => jobSnippets(request, target)} />}
    </Stack>
  );
}

interface VolumeSelectProps {
  label: string;
  description?: string;
  required?: boolean;
  volumes: readonly Asset[];
  value: string | null;
  /** Whether they are here. */
  known: boolean;
  onChange: (id: string | null) => void;
}

function VolumeSelect({ label, description, required = false, volumes, value, known, onChange }: VolumeSelectProps) {
  const byId = new Map(volumes.map((volume) => [volume.id, volume]));
  const data: ComboboxItem[] = volumes.map((volume) => ({
    value: volume.id,
    label: volume.filename,
  }));
  return (
    <Select
      label={label}
      {...(description ? { description } : {})}
      required={required}
      placeholder={
        !known ? "The volumes are not here yet" : volumes.length === 0 ? "Upload a volume first" : "Choose a volume"
      }
      data={data}
      searchable
      clearable={!required}
      allowDeselect={!required}
      nothingFoundMessage="No volume of that name"
      maxDropdownHeight={320}
      value={value}
      onChange={onChange}
      renderOption={({ option }) => {
        const volume = byId.get(option.value);
        return (
          <div style={{ minWidth: 0 }}>
            <Text size="sm" truncate>
              {option.label}
            </Text>
            <Text size="xs" c="dimmed">
              {volume ? describeAsset(volume) : ""}
            </Text>
          </div>
        );
      }}
    />
  );
}
