import {
  Alert,
  Button,
  Collapse,
  type ComboboxItem,
  NumberInput,
  Paper,
  Select,
  Slider,
  Stack,
  Text,
  Textarea,
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
import { parseSeeds, type SegmentationParams } from "./params";
import { guessRoles, type Roles } from "./roles";

type Topology = NonNullable<SegmentationParams["topology"]>;

interface Advanced {
  seeds: string;
  maxObjects: number | "";
  topology: Topology;
  edgeLength: number | "";
  smoothing: number;
  randomSeed: number | "";
}

const DEFAULTS: Advanced = {
  seeds: "",
  maxObjects: 8,
  topology: "preserve",
  edgeLength: "",
  smoothing: 0.12,
  randomSeed: 0,
};

/** Starts a segmentation; `recent` are the assets just uploaded, which are most likely meant. */
export function SegmentForm({ recent }: { recent: readonly string[] }) {
  const navigate = useNavigate();
  const asked = useSearch({ from: "/upload" });
  const volumes = useQuery(volumesQuery);
  const kinds = useQuery(kindsQuery);
  const create = useCreateJob();
  const [chosen, setChosen] = useState<Partial<Roles>>({});
  const [open, setOpen] = useState(false);
  const [advanced, setAdvanced] = useState(DEFAULTS);
  const set = (change: Partial<Advanced>) => setAdvanced((before) => ({ ...before, ...change }));
  const [attempts] = useState(() => new Attempts());

  const all = volumes.data?.items ?? [];
  const guessed = useMemo(() => {
    const items = volumes.data?.items ?? [];
    const fresh = items.filter((volume) => recent.includes(volume.id));
    return fresh.length > 0 ? guessRoles(fresh) : { post: asked.post ?? null, pre: asked.pre ?? null };
  }, [volumes.data, recent, asked.post, asked.pre]);
  const roles: Roles = { ...guessed, ...chosen };
  const known = (id: string | null) => (id && all.some((volume) => volume.id === id) ? id : null);
  const post = known(roles.post);
  const pre = known(roles.pre);
  const { seeds, problem: seedProblem } = parseSeeds(advanced.seeds);
  const kind = kinds.data?.find(({ name }) => name === "segmentation");

  const request: JobCreate = {
    kind: "segmentation",
    inputs: { post: post ?? "", ...(pre ? { pre } : {}) },
    params: changedParams(advanced, seeds),
  };
  const submit = (event: SubmitEvent) => {
    event.preventDefault();
    if (!post || seedProblem) return;
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
                Finds the enhancing tumor, what it encloses, and their surface.
              </Text>
            </div>
            {kind && kind.workers === 0 && (
              <Alert color="orange" variant="light">
                No worker for segmentation is running at the moment. The job will wait for one.
              </Alert>
            )}
            <VolumeSelect
              label="After contrast (T1c)"
              required
              volumes={all.filter(({ id }) => id !== pre)}
              value={post}
              loading={volumes.isLoading}
              onChange={(id) => setChosen((before) => ({ ...before, post: id }))}
            />
            <VolumeSelect
              label="Before contrast (T1)"
              description="Optional: with it, what was bright from the start is told from what takes up contrast."
              volumes={all.filter(({ id }) => id !== post)}
              value={pre}
              loading={volumes.isLoading}
              onChange={(id) => setChosen((before) => ({ ...before, pre: id }))}
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
                Advanced
              </Button>
              <Collapse expanded={open} id="advanced" pt={open ? "sm" : 0}>
                <Stack gap="md">
                  <Textarea
                    label="Seed points"
                    description="RAS millimetres, one point to a line. Empty: seeds are found automatically."
                    placeholder="12.5, -30, 41"
                    autosize
                    minRows={2}
                    maxRows={6}
                    value={advanced.seeds}
                    error={seedProblem}
                    onChange={(event) => set({ seeds: event.currentTarget.value })}
                  />
                  <NumberInput
                    label="Objects at the most"
                    min={1}
                    max={64}
                    allowDecimal={false}
                    value={advanced.maxObjects}
                    onChange={(value) => set({ maxObjects: typeof value === "number" ? value : "" })}
                  />
                  <Select
                    label="Topology"
                    description="Whether the surface keeps its genus, or may merge and split."
                    data={[
                      { value: "preserve", label: "Preserve" },
                      { value: "adaptive", label: "Adaptive" },
                    ]}
                    allowDeselect={false}
                    value={advanced.topology}
                    onChange={(value) => set({ topology: value ?? "preserve" })}
                  />
                  <NumberInput
                    label="Edge length of the mesh"
                    description="Empty: chosen from the voxels' spacing."
                    suffix=" mm"
                    min={0.1}
                    max={50}
                    step={0.1}
                    decimalScale={2}
                    value={advanced.edgeLength}
                    onChange={(value) => set({ edgeLength: typeof value === "number" ? value : "" })}
                  />
                  <div>
                    <Text size="sm" fw={500}>
                      Smoothing
                    </Text>
                    <Slider
                      thumbLabel="Smoothing"
                      min={0}
                      max={1}
                      step={0.01}
                      marks={[{ value: DEFAULTS.smoothing }]}
                      value={advanced.smoothing}
                      onChange={(value) => set({ smoothing: value })}
                    />
                  </div>
                  <NumberInput
                    label="Random seed"
                    min={0}
                    max={2 ** 32 - 1}
                    allowDecimal={false}
                    value={advanced.randomSeed}
                    onChange={(value) => set({ randomSeed: typeof value === "number" ? value : "" })}
                  />
                  <Button
                    variant="subtle"
                    color="gray"
                    size="compact-sm"
                    w="fit-content"
                    onClick={() => setAdvanced(DEFAULTS)}
                  >
                    Back to the defaults
                  </Button>
                </Stack>
              </Collapse>
            </div>
            {create.isError && <Failure error={create.error} />}
            {volumes.isError && <Failure error={volumes.error} onRetry={() => void volumes.refetch()} />}
            <Button type="submit" disabled={!post || seedProblem !== null} loading={create.isPending}>
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
  loading: boolean;
  onChange: (id: string | null) => void;
}

function VolumeSelect({ label, description, required = false, volumes, value, loading, onChange }: VolumeSelectProps) {
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
      placeholder={loading ? "Loading…" : volumes.length === 0 ? "Upload a volume first" : "Choose a volume"}
      data={data}
      searchable
      clearable={!required}
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

/** Only what differs from the defaults is sent, so that the server's own defaults hold. */
function changedParams(advanced: Advanced, seeds: [number, number, number][]): Record<string, unknown> {
  return {
    ...(seeds.length > 0 ? { seeds } : {}),
    ...(advanced.maxObjects !== "" && advanced.maxObjects !== DEFAULTS.maxObjects
      ? { max_objects: advanced.maxObjects }
      : {}),
    ...(advanced.topology !== DEFAULTS.topology ? { topology: advanced.topology } : {}),
    ...(advanced.edgeLength !== "" ? { edge_length: advanced.edgeLength } : {}),
    ...(advanced.smoothing !== DEFAULTS.smoothing ? { smoothing: advanced.smoothing } : {}),
    ...(advanced.randomSeed !== "" && advanced.randomSeed !== DEFAULTS.randomSeed
      ? { random_seed: advanced.randomSeed }
      : {}),
  };
}
