import { Paper, Text, Title } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { kindsQuery } from "@/api/queries";
import type { Asset, Job } from "@/api/types";
import { Facts } from "@/app/Facts";
import { describeAsset } from "@/format/asset";
import { moment } from "@/format/format";
import { changedParams } from "./changedParams";
import { SaveLink } from "./SaveLink";

const ROLES: Record<string, string> = {
  post: "After contrast",
  pre: "Before contrast",
  vessels: "Vessels",
  sequence: "Sequence",
  mesh: "Mesh",
  motion: "Motion",
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
      <Facts
        values="beside"
        rows={[
          ...Object.entries(job.inputs).map(
            ([role, ids]) => [ROLES[role] ?? role, <Input key={role} ids={ids} assets={assets} />] as const,
          ),
          ...params.map(
            ([name, value]) => [name.replaceAll("_", " "), <code key={name}>{JSON.stringify(value)}</code>] as const,
          ),
          ["Created", moment(job.created_at)],
          ...(job.finished_at ? [["Ended", moment(job.finished_at)] as const] : []),
          [
            "Id",
            <Text key="id" size="xs" ff="monospace">
              {job.id}
            </Text>,
          ],
        ]}
      />
    </Paper>
  );
}

function Input({ ids, assets }: { ids: string[]; assets: ReadonlyMap<string, Asset> }) {
  const asset = assets.get(ids[0] ?? "");
  if (!asset) {
    return (
      <Text size="xs" ff="monospace" c="dimmed">
        {ids[0]}
      </Text>
    );
  }
  return (
    <>
      <SaveLink url={asset.content_url} name={asset.filename}>
        {asset.filename}
      </SaveLink>
      {ids.length > 1 ? ` and ${ids.length - 1} more` : ""}
      <Text size="xs" c="dimmed">
        {describeAsset(asset)}
      </Text>
    </>
  );
}
