import { Paper, Title } from "@mantine/core";
import { duration } from "@/format/format";
import classes from "./jobs.module.css";

/** Where a job's time went. */
export function StageTimes({ stages }: { stages: readonly { name: string; seconds: number }[] }) {
  const longest = Math.max(...stages.map(({ seconds }) => seconds), 1e-9);
  if (stages.length === 0) return null;
  return (
    <Paper p="md" component="section" aria-label="Time by stage">
      <Title order={3} mb="xs">
        Time by stage
      </Title>
      <dl className={classes.times}>
        {stages.map(({ name, seconds }) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd>
              <span className={classes.bar} style={{ width: `${(seconds / longest) * 100}%` }} aria-hidden="true" />
            </dd>
            <dd>{duration(seconds)}</dd>
          </div>
        ))}
      </dl>
    </Paper>
  );
}
