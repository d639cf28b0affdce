import { Button, Table, UnstyledButton } from "@mantine/core";
import { useState } from "react";
import { anatomical, integer, millimetres, volume } from "@/format/format";
import { LABELS } from "@/viewers/labels";
import type { Point, SegmentationResult } from "./params";
import { Structures } from "./Structures";
import classes from "./segmentation.module.css";

const FIRST = 8;

interface BleedingTableProps {
  result: SegmentationResult;
  /** Look at a place, RAS mm. */
  onLook: (place: Point) => void;
}

/** Clusters of bleeding, the largest first. */
export function BleedingTable({ result, onLook }: BleedingTableProps) {
  const [all, setAll] = useState(false);
  const clusters = result.microhemorrhages ?? [];
  if (clusters.length === 0) return null;
  const size = clusters.reduce((sum, { volume_mm3 }) => sum + volume_mm3, 0);
  return (
    <Structures
      id="bleedings"
      color={LABELS[3].color}
      title={clusters.length === 1 ? "1 microhemorrhage" : `${clusters.length} microhemorrhages`}
      says={`${volume(size)} together`}
    >
      <Table.ScrollContainer minWidth={420} type="native">
        <Table verticalSpacing={6}>
          <Table.Thead>
            <Table.Tr>
              <Table.Th>Middle</Table.Th>
              <Table.Th ta="right">Volume</Table.Th>
              <Table.Th ta="right">Voxels</Table.Th>
              <Table.Th ta="right">Diameter as a ball</Table.Th>
            </Table.Tr>
          </Table.Thead>
          <Table.Tbody>
            {clusters.slice(0, all ? undefined : FIRST).map(({ centroid, volume_mm3: mm3, voxels }) => {
              const [x = 0, y = 0, z = 0] = centroid;
              return (
                <Table.Tr key={centroid.join()}>
                  <Table.Td>
                    <UnstyledButton
                      className={classes.pick ?? ""}
                      aria-label={`Look at ${anatomical([x, y, z])}`}
                      onClick={() => onLook([x, y, z])}
                    >
                      {anatomical([x, y, z])}
                    </UnstyledButton>
                  </Table.Td>
                  <Table.Td ta="right">{volume(mm3)}</Table.Td>
                  <Table.Td ta="right">{integer(voxels)}</Table.Td>
                  <Table.Td ta="right">{millimetres(2 * Math.cbrt((3 * mm3) / (4 * Math.PI)))}</Table.Td>
                </Table.Tr>
              );
            })}
          </Table.Tbody>
        </Table>
      </Table.ScrollContainer>
      {clusters.length > FIRST && (
        <Button variant="subtle" color="gray" size="compact-sm" mt="xs" onClick={() => setAll(!all)}>
          {all ? "Only the largest" : `All ${clusters.length}`}
        </Button>
      )}
    </Structures>
  );
}
