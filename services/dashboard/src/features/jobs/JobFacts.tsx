import { Anchor, Paper, Text, Title } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { kindsQuery } from "@/api/queries";
import type { Asset, Job } from "@/api/types";
import { describeAsset } from "@/format/asset";
import { moment } from "@/format/format";
import { changedParams } from "./changedParams";
import classes from "./jobs.module.css";
import { SaveLink } from "./SaveLink";

const ROLES: Record<string, string> = {
  post: "After contrast",
  pre: "Before contrast",
  vessels: "Vessels",
};

/** What a job was started with, and its numbers for those who look behind it. */
export function JobFacts({ job, assets }: { job: Job; assets: ReadonlyMap<string, Asset> }) {
  const kinds = useQuery(kindsQuery);
  const schema = kinds.data?.find(({ name }) => name === job.kind)?.params_schema;
  const params = changedParams(job.params, schema);
  return (
    <Paper p="md" component="section" aria-label="About this job">
      <Title order={3} mb="xs">
        About this job
      </Title>
      <dl className={classes.facts}>
        {Object.entries(job.inputs).map(([role, ids]) => (
          <Input key={role} role={ROLES[role] ?? role} ids={ids} assets={assets} />
        ))}
        {params.map(([name, value]) => (
          <Fact key={name} name={name.replaceAll("_", " ")}>
            <code>{JSON.stringify(value)}</code>
          </Fact>
        ))}
        <Fact name="Created">{moment(job.created_at)}</Fact>
        {job.finished_at && <Fact name="Ended">{moment(job.finished_at)}</Fact>}
        <Fact name="Id">
          <Text size="xs" ff="monospace">
            {job.id}
          </Text>
        </Fact>
      </dl>
    </Paper>
  );
}

function Fact({ name, children }: { name: string; children: React.ReactNode }) {
  return (
    <>
      <dt>{name}</dt>
      <dd>{children}</dd>
    </>
  );
}

function Input({ role, ids, assets }: { role: string; ids: string[]; assets: ReadonlyMap<string, Asset> }) {
  const asset = assets.get(ids[0] ?? "");
  return (
    <Fact name={role}>
      {asset ? (
        <>
          <SaveLink url={asset.content_url} name={asset.filename}>
            {asset.filename}
          </SaveLink>
          {ids.length > 1 ? ` and ${ids.length - 1} more` : ""}
          <Text size="xs" c="dimmed">
            {describeAsset(asset)}
          </Text>
        </>
      ) : (
        <Anchor component="span" size="xs" ff="monospace" c="dimmed" underline="never">
          {ids[0]}
        </Anchor>
      )}
    </Fact>
  );
}
