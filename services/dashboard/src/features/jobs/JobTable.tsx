import { Box, Group, Progress, Table, type TableThProps, Text, UnstyledButton } from "@mantine/core";
import { ArrowDown, ArrowUp, ArrowUpDown } from "lucide-react";
import { isTerminal, type Job, type JobOrder } from "@/api/types";
import { LinkAnchor } from "@/app/links";
import { useNow } from "@/app/useNow";
import { ago, capital, duration, moment, percent } from "@/format/format";
import { JobActions } from "./JobActions";
import classes from "./jobs.module.css";
import { jobName, outcome, secondsSpent, workName } from "./naming";
import { type Column, reordered, sortOf } from "./sorting";
import { StateBadge } from "./StateBadge";

interface JobTableProps {
  jobs: readonly Job[];
  order: JobOrder;
  onOrder: (order: JobOrder) => void;
  /** Whether these are still those of the page or filter before. */
  stale: boolean;
}

/** Jobs, one a row, with how they are now. */
export function JobTable({ jobs, order, onOrder, stale }: JobTableProps) {
  const now = useNow(jobs.some((job) => !isTerminal(job.state)) ? 1_000 : 30_000);
  const head = { order, onOrder };
  return (
    <Box className={classes.frame} aria-busy={stale}>
      <Table highlightOnHover verticalSpacing="sm" horizontalSpacing="md" className={classes.table ?? ""}>
        <Table.Thead>
          <Table.Tr>
            <Head by="name" label="Job" {...head} />
            <Head by="state" label="State" {...head} w={130} />
            <Table.Th w="36%">Progress and outcome</Table.Th>
            <Head by="took" label="Took" {...head} w={116} visibleFrom="md" />
            <Head by="created" label="Created" {...head} w={150} visibleFrom="md" />
            <Table.Th w={110}>
              <span className={classes.unseen}>Actions</span>
            </Table.Th>
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {jobs.map((job) => (
            <JobRow key={job.id} job={job} name={jobName(job)} now={now} />
          ))}
        </Table.Tbody>
      </Table>
    </Box>
  );
}

interface HeadProps extends Pick<TableThProps, "w" | "visibleFrom"> {
  by: Column;
  label: string;
  order: JobOrder;
  onOrder: (order: JobOrder) => void;
}

const ICONS = { ascending: ArrowUp, descending: ArrowDown, none: ArrowUpDown };

/** The head of a column that the list is sorted by, all of it and not the page alone. */
function Head({ by, label, order, onOrder, ...others }: HeadProps) {
  const sorted = sortOf(order, by);
  const Icon = ICONS[sorted];
  return (
    <Table.Th aria-sort={sorted} {...others}>
      <UnstyledButton
        className={classes.head ?? ""}
        data-on={sorted !== "none" || undefined}
        onClick={() => onOrder(reordered(order, by))}
      >
        {label}
        <Icon size={13} aria-hidden="true" />
      </UnstyledButton>
    </Table.Th>
  );
}

function JobRow({ job, name, now }: { job: Job; name: string; now: number }) {
  const spent = secondsSpent(job, now);
  return (
    <Table.Tr data-job={job.id} className={classes.row ?? ""}>
      <Table.Td>
        <LinkAnchor
          to="/jobs/$jobId"
          params={{ jobId: job.id }}
          fw={600}
          c="var(--mantine-color-text)"
          className={classes.name ?? ""}
          title={name}
        >
          {name}
        </LinkAnchor>
        <Text size="xs" c="dimmed">
          {workName(job.kind)}
          {job.attempt > 1 ? ` · attempt ${job.attempt}` : ""}
          <Text span inherit hiddenFrom="md">
            {" "}
            · {ago(job.created_at, now)}
          </Text>
        </Text>
      </Table.Td>
      <Table.Td>
        <StateBadge state={job.state} />
      </Table.Td>
      <Table.Td>
        <Outcome job={job} name={name} />
      </Table.Td>
      <Table.Td visibleFrom="md">
        <Text size="sm">{spent === null ? "–" : duration(spent)}</Text>
      </Table.Td>
      <Table.Td visibleFrom="md">
        <Text size="sm" c="dimmed" title={moment(job.created_at)}>
          {ago(job.created_at, now)}
        </Text>
      </Table.Td>
      <Table.Td ta="right">
        <JobActions job={job} name={name} compact />
      </Table.Td>
    </Table.Tr>
  );
}

function Outcome({ job, name }: { job: Job; name: string }) {
  if (job.error) {
    return (
      <>
        <Text size="sm">{job.error.message}</Text>
        {job.error.hint && (
          <Text size="xs" c="dimmed">
            {job.error.hint}
          </Text>
        )}
      </>
    );
  }
  if (job.state === "running" || job.state === "cancelling") {
    return (
      <>
        <Group justify="space-between" gap="xs" wrap="nowrap">
          <Text size="sm" truncate>
            {job.stage ? capital(job.stage) : "Starting"}
            {job.message ? (
              <Text span size="sm" c="dimmed">
                {" "}
                · {job.message}
              </Text>
            ) : null}
          </Text>
          <Text size="sm" c="dimmed">
            {percent(job.fraction)}
          </Text>
        </Group>
        <Progress
          value={job.fraction * 100}
          size={5}
          mt={5}
          aria-label={`${name}: ${percent(job.fraction)}`}
          transitionDuration={200}
        />
      </>
    );
  }
  return (
    <Text size="sm" c={job.expired || job.state !== "succeeded" ? "dimmed" : undefined}>
      {job.state === "queued" ? "Waiting for a worker" : outcome(job)}
    </Text>
  );
}
