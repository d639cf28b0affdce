import { Group, Paper, Text, Title, UnstyledButton } from "@mantine/core";
import { volume } from "@/format/format";
import { LABELS } from "@/viewers/labels";
import type { SurfaceFile } from "@/viewers/surface/SurfaceViewer";
import type { SegmentationResult } from "./params";
import classes from "./segmentation.module.css";

interface StructureTableProps {
  result: SegmentationResult;
  surfaces: readonly SurfaceFile[];
  chosen: number | null;
  onChoose: (id: number | null) => void;
}

/** Vessels and bleedings, where they were looked for: how much there is, and their surfaces to pick one by one. */
export function StructureTable({ result, surfaces, chosen, onChoose }: StructureTableProps) {
  const found = LABELS.slice(2).flatMap(({ value, name, color }) => {
    const voxels = result.voxel_counts[String(value)] ?? 0;
    return voxels > 0 ? [{ value, name, color, size: voxels * result.voxel_volume_mm3 }] : [];
  });
  if (found.length === 0) return null;
  return (
    <Paper p="md" component="section" aria-labelledby="structures">
      <Title order={2} id="structures" mb="xs">
        Vessels and bleedings
      </Title>
      <ul className={classes.structures}>
        {found.map(({ value, name, color, size }) => (
          <li key={value}>
            <span className={classes.swatch} style={{ background: color }} aria-hidden="true" />
            <Text size="sm" fw={550}>
              {name}
            </Text>
            <Text size="sm" c="dimmed">
              {volume(size)}
            </Text>
            <Group gap="sm">
              {surfaces
                .filter((surface) => surface.color === color)
                .map(({ id, title }) => (
                  <UnstyledButton
                    key={id}
                    className={classes.pick ?? ""}
                    aria-pressed={id === chosen}
                    onClick={() => onChoose(id === chosen ? null : id)}
                  >
                    {title}
                  </UnstyledButton>
                ))}
            </Group>
          </li>
        ))}
      </ul>
    </Paper>
  );
}
