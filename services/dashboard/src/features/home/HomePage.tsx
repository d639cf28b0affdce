import { Paper, SimpleGrid, Stack, Text, Title } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { Link, type LinkProps } from "@tanstack/react-router";
import { Brain, Film, Layers, type LucideIcon, Shapes } from "lucide-react";
import { jobsQuery, kindsQuery } from "@/api/queries";
import { isTerminal, type JobKind } from "@/api/types";
import { LinkAnchor } from "@/app/links";
import { Failure, Waiting } from "@/app/Notice";
import { Page } from "@/app/Page";
import { useNow } from "@/app/useNow";
import { jobName, outcome } from "@/features/jobs/naming";
import { StateBadge } from "@/features/jobs/StateBadge";
import { ago, percent } from "@/format/format";
import classes from "./home.module.css";
import { ServerState } from "./ServerState";

interface Task {
  title: string;
  says: string;
  icon: LucideIcon;
  to: LinkProps["to"];
  /** The job kind that it starts. */
  kind: string;
}

const TASKS: readonly Task[] = [
  {
    title: "Find a tumor’s surface",
    says: "From a T1 volume after contrast, and the one before if you have it: labels, a closed surface, measurements.",
    icon: Brain,
    to: "/upload",
    kind: "segmentation",
  },
  {
    title: "Segment a whole study",
    says: "Pick the volumes, or take all that were uploaded: one batch, its progress as a whole, failures run again alone.",
    icon: Layers,
    to: "/batches/new",
    kind: "segmentation",
  },
  {
    title: "Find a shape by example",
    says: "Drop a mesh, or paint a part of one: what in your bank resembles it, whole or in part, in any pose.",
    icon: Shapes,
    to: "/shapes/search",
    kind: "shape-search",
  },
  {
    title: "Compress a motion",
    says: "A mesh sequence becomes one small file that plays in the browser, with the error that you allow.",
    icon: Film,
    to: "/motion",
    kind: "motion-encode",
  },
];

const SHOWN = 6;

export function HomePage() {
  const kinds = useQuery(kindsQuery);
  return (
    <Page
      title="What shape is hidden in it?"
      tab="Start"
      lead="Surfaces hidden in volumes, shapes hidden in a bank of shapes, and the few motions hidden in long mesh sequences. The work runs here, on this server."
    >
      <div className={classes.columns}>
        <Stack gap="xl">
          <SimpleGrid component="nav" cols={{ base: 1, xs: 2 }} spacing="md" aria-label="What you can do">
            {TASKS.map((task) => (
              <TaskCard key={task.title} task={task} kind={kinds.data?.find(({ name }) => name === task.kind)} />
            ))}
          </SimpleGrid>
          <RecentWork />
        </Stack>
        <ServerState />
      </div>
    </Page>
  );
}

function TaskCard({ task: { title, says, icon: Icon, to }, kind }: { task: Task; kind: JobKind | undefined }) {
  return (
    <Link to={to} className={classes.task}>
      <span className={classes.icon}>
        <Icon size={22} strokeWidth={1.6} aria-hidden="true" />
      </span>
      <span className={classes.taskTitle}>{title}</span>
      <Text component="span" size="sm" c="dimmed">
        {says}
      </Text>
      {kind?.workers === 0 && (
        <Text component="span" size="xs" c="var(--warn)" mt={2}>
          No worker for this is running at the moment.
        </Text>
      )}
    </Link>
  );
}

function RecentWork() {
  const jobs = useQuery({
    ...jobsQuery({}),
    refetchInterval: ({ state }) => (state.data?.items.some((job) => !isTerminal(job.state)) ? 2_000 : 10_000),
  });
  const items = (jobs.data?.items ?? []).slice(0, SHOWN);
  const now = useNow(10_000);
  return (
    <section aria-labelledby="recent">
      <div className={classes.heading}>
        <Title order={2} id="recent">
          Recent work
        </Title>
        {items.length > 0 && (
          <LinkAnchor to="/jobs" size="sm">
            All jobs
          </LinkAnchor>
        )}
      </div>
      {jobs.isPending ? (
        <Waiting label="Loading the jobs…" />
      ) : jobs.isError && !jobs.data ? (
        <Failure error={jobs.error} onRetry={() => void jobs.refetch()} />
      ) : items.length === 0 ? (
        <Paper p="lg">
          <Text size="sm" c="dimmed">
            Nothing yet. What you start appears here, and goes on when you leave the page.
          </Text>
        </Paper>
      ) : (
        <ul className={classes.recent}>
          {items.map((job) => {
            const name = jobName(job);
            return (
              <li key={job.id}>
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
                <StateBadge state={job.state} />
                <Text size="sm" c="dimmed" className={classes.outcome ?? ""}>
                  {job.error
                    ? job.error.message
                    : job.state === "running"
                      ? `${percent(job.fraction)} ${job.stage}`
                      : outcome(job)}
                </Text>
                <Text size="sm" c="dimmed" className={classes.when ?? ""}>
                  {ago(job.created_at, now)}
                </Text>
              </li>
            );
          })}
        </ul>
      )}
    </section>
  );
}
