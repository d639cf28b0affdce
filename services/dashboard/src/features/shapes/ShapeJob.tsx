import { Group, Paper, Text, Title } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { ScanSearch, Shapes } from "lucide-react";
import { shapeOfJobQuery } from "@/api/shapes";
import type { Job } from "@/api/types";
import { LinkButton } from "@/app/links";
import { Empty, Failure, Waiting } from "@/app/Notice";
import { integer } from "@/format/format";
import { addressOf, isSearchResult } from "./result";
import { ShapePicture } from "./ShapePicture";

/** What a job of the shape database has left: a shape, or what a search has found. */
export default function ShapeJob({ job }: { job: Job }) {
  return isSearchResult(job.result) ? <Searched job={job} found={job.result.hits.length} /> : <Indexed job={job} />;
}

function Indexed({ job }: { job: Job }) {
  const shape = useQuery(shapeOfJobQuery(job.id));
  if (shape.isPending) return <Waiting label="Loading the shape…" />;
  if (shape.isError) return <Failure error={shape.error} onRetry={() => void shape.refetch()} />;
  if (!shape.data) {
    return (
      <Paper>
        <Empty icon={<Shapes size={32} />} title="The shape is no longer there">
          <Text size="sm" c="dimmed">
            It was deleted, or has been indexed again since.
          </Text>
        </Empty>
      </Paper>
    );
  }
  return (
    <Paper p="lg">
      <Group gap="lg" wrap="nowrap" align="center">
        <ShapePicture shape={shape.data} size={160} />
        <div>
          <Title order={2}>{shape.data.name || "A shape without a name"}</Title>
          <Text size="sm" c="dimmed" mb="md">
            in {shape.data.collection}
          </Text>
          <Group gap="sm">
            <LinkButton to="/shapes/$shapeId" params={{ shapeId: shape.data.id }}>
              Open the shape
            </LinkButton>
            <LinkButton to="/shapes/search" search={{ shape: shape.data.id }} variant="default">
              Find similar
            </LinkButton>
          </Group>
        </div>
      </Group>
    </Paper>
  );
}

function Searched({ job, found }: { job: Job; found: number }) {
  return (
    <Paper>
      <Empty icon={<ScanSearch size={32} />} title={found === 1 ? "1 shape was found" : `${integer(found)} were found`}>
        <LinkButton to="/shapes/search" search={addressOf(job)} mt="sm">
          See them
        </LinkButton>
      </Empty>
    </Paper>
  );
}
