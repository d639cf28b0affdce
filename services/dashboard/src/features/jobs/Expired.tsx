import { Button, Group, Paper, Stack, Text, Title } from "@mantine/core";
import { useNavigate } from "@tanstack/react-router";
import { RotateCw } from "lucide-react";
import { useState } from "react";
import { Attempts } from "@/api/idempotency";
import { useCreateJob } from "@/api/queries";
import type { Job } from "@/api/types";
import { LinkButton } from "@/app/links";
import { Failure } from "@/app/Notice";
import { moment } from "@/format/format";
import classes from "./jobs.module.css";
import { workName } from "./naming";

/** In the place of results whose time is over: when that was, what is left, and the same work once more. */
export function Expired({ job }: { job: Job }) {
  const navigate = useNavigate();
  const create = useCreateJob();
  const [attempts] = useState(() => new Attempts());
  const request = { kind: job.kind, inputs: job.inputs, params: job.params };
  const run = () =>
    create.mutate(
      { request, idempotencyKey: attempts.keyFor(request) },
      { onSuccess: (next) => void navigate({ to: "/jobs/$jobId", params: { jobId: next.id } }) },
    );
  return (
    <Paper p="xl" component="section" aria-labelledby="expired">
      <Stack align="center" gap="xs" ta="center" py="lg">
        <Faded />
        <Title order={2} id="expired">
          The results have expired
        </Title>
        <Text size="sm" c="dimmed" maw={460}>
          They were kept until {job.expires_at ? moment(job.expires_at) : "their time was over"}. What the job was
          started with is known: run it again, and the same results come back.
        </Text>
        {create.isError && <Failure error={create.error} />}
        <Group mt="sm" justify="center">
          <Button leftSection={<RotateCw size={16} aria-hidden="true" />} loading={create.isPending} onClick={run}>
            Run it again
          </Button>
          <LinkButton to="/jobs" variant="default">
            Other jobs
          </LinkButton>
        </Group>
        <Text size="xs" c="dimmed">
          {workName(job.kind)}. Download what you want to keep; how long results stay is under Keys and settings.
        </Text>
      </Stack>
    </Paper>
  );
}

/** A surface that is going: its outline dissolves into dots. */
function Faded() {
  return (
    <svg className={classes.faded} viewBox="0 0 160 110" aria-hidden="true">
      <path d="M88 18c-26-10-56 4-60 30-4 24 14 44 40 44 12 0 14-6 26-8" />
      <path d="M84 34c-16-5-34 3-37 19-2 15 9 26 25 26" />
      <path d="M80 50c-7-2-15 1-16 8-1 6 4 10 10 10" />
      {DOTS.map(([x, y, r]) => (
        <circle key={`${x} ${y}`} cx={x} cy={y} r={r} />
      ))}
    </svg>
  );
}

const DOTS: readonly (readonly [number, number, number])[] = [
  [98, 24, 2.6],
  [107, 31, 2.3],
  [115, 41, 2],
  [118, 53, 1.8],
  [115, 65, 2],
  [107, 76, 2.3],
  [100, 44, 1.9],
  [103, 57, 1.7],
  [126, 36, 1.5],
  [131, 51, 1.2],
  [127, 68, 1.4],
  [139, 44, 0.9],
  [141, 60, 0.8],
  [90, 62, 1.7],
  [93, 71, 1.6],
];
