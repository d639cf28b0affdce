import { Paper, Text, Title } from "@mantine/core";
import type { ShapeDetail } from "@/api/types";
import { Facts } from "@/app/Facts";
import { LinkAnchor } from "@/app/links";
import { integer, moment, significant } from "@/format/format";
import classes from "./shape.module.css";

/** What repair did, in words; the counts are told beside. */
const CHANGES: Record<string, string> = {
  weld: "vertices in one place became one",
  drop_degenerate_faces: "faces without area left out",
  drop_duplicate_faces: "faces that were there twice left out",
  drop_unreferenced_vertices: "vertices without a face left out",
  orient: "faces turned outwards",
  leave_out_specks: "specks too small to matter left out",
  reduce_faces: "faces fewer, as it was too fine",
  split_edges: "vertices added on long edges",
  link_components: "components joined where they are nearest",
};

/** What the mesh is like, and what was done to it before it was analysed. */
export function ShapeFacts({ shape }: { shape: ShapeDetail }) {
  const [low = [], high = []] = shape.bounding_box;
  const extent = high.map((value, axis) => significant(value - (low[axis] ?? 0), 3)).join(" × ");
  const rows: [string, React.ReactNode][] = [
    ["Vertices", integer(shape.vertices)],
    ["Faces", integer(shape.faces)],
    ["Components", integer(shape.components)],
    ["Surface", shape.closed ? "closed" : "open"],
    ["Handles", shape.genus === null ? "unknown: not a clean surface" : integer(shape.genus)],
    ["Area", significant(shape.area, 4)],
    ["Extent", extent],
    ["Parts", shape.levels.map(({ parts }) => parts).join(", ")],
    ["Index version", shape.index_version],
    ["Added", moment(shape.created_at)],
    [
      "Indexed by",
      <LinkAnchor key="job" to="/jobs/$jobId" params={{ jobId: shape.job_id }} size="sm">
        job {shape.job_id.slice(-8)}
      </LinkAnchor>,
    ],
  ];
  return (
    <Paper p="md" component="section" aria-labelledby="facts">
      <Title order={2} id="facts" mb="xs">
        The mesh
      </Title>
      <Facts rows={rows} values="below" />
      <Title order={3} mt="md" mb={4}>
        Before it was analysed
      </Title>
      {shape.changes.length === 0 ? (
        <Text size="sm" c="dimmed">
          Nothing had to be repaired.
        </Text>
      ) : (
        <ul className={classes.changes}>
          {shape.changes.map(({ name, count }) => (
            <li key={name}>
              {integer(count)} {CHANGES[name] ?? name.replaceAll("_", " ")}
            </li>
          ))}
        </ul>
      )}
      {shape.changes.length > 0 && (
        <Text size="xs" c="dimmed" mt={4}>
          The mesh that was uploaded stays as it is.
        </Text>
      )}
    </Paper>
  );
}
