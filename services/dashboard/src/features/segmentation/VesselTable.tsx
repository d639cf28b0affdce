import { Table, UnstyledButton } from "@mantine/core";
import { area, integer, millimetres, significant, volume } from "@/format/format";
import { LABELS } from "@/viewers/labels";
import type { SegmentationResult } from "./params";
import { Structures } from "./Structures";
import { vesselId } from "./surfaces";
import classes from "./segmentation.module.css";

interface VesselTableProps {
  result: SegmentationResult;
  /** Of surfaces. */
  chosen: number | null;
  onChoose: (id: number | null) => void;
}

/** The vessels that were found: how long, how thick, how branched. */
export function VesselTable({ result, chosen, onChoose }: VesselTableProps) {
  const vessels = result.vessels ?? [];
  if (vessels.length === 0) return null;
  const length = vessels.reduce((sum, { length_mm }) => sum + length_mm, 0);
  const size = vessels.reduce((sum, { volume_mm3 }) => sum + volume_mm3, 0);
  return (
    <Structures
      id="vessels"
      color={LABELS[2].color}
      title={vessels.length === 1 ? "1 vessel" : `${vessels.length} vessels`}
      says={`${millimetres(length)} long together, ${volume(size)}${result.vessel_polarity ? `, ${result.vessel_polarity} in the data` : ""}`}
    >
      <Table.ScrollContainer minWidth={560} type="native">
        <Table verticalSpacing="xs">
          <Table.Thead>
            <Table.Tr>
              <Table.Th>Vessel</Table.Th>
              <Table.Th ta="right">Length</Table.Th>
              <Table.Th ta="right">Mean radius</Table.Th>
              <Table.Th ta="right">Radius range</Table.Th>
              <Table.Th ta="right">Branches</Table.Th>
              <Table.Th ta="right">Forks</Table.Th>
              <Table.Th ta="right">Volume</Table.Th>
              <Table.Th ta="right">Surface</Table.Th>
            </Table.Tr>
          </Table.Thead>
          <Table.Tbody>
            {vessels.map((vessel) => {
              const id = vesselId(vessel.label);
              return (
                <Table.Tr key={id} data-chosen={id === chosen || undefined} className={classes.object ?? ""}>
                  <Table.Td>
                    <UnstyledButton
                      className={classes.pick ?? ""}
                      aria-pressed={id === chosen}
                      onClick={() => onChoose(id === chosen ? null : id)}
                    >
                      Vessel {vessel.label}
                    </UnstyledButton>
                  </Table.Td>
                  <Table.Td ta="right">{millimetres(vessel.length_mm)}</Table.Td>
                  <Table.Td ta="right">{millimetres(vessel.mean_radius_mm)}</Table.Td>
                  <Table.Td ta="right" style={{ whiteSpace: "nowrap" }}>
                    {significant(vessel.least_radius_mm, 3)} – {millimetres(vessel.largest_radius_mm)}
                  </Table.Td>
                  <Table.Td ta="right">{integer(vessel.branches)}</Table.Td>
                  <Table.Td ta="right">{integer(vessel.forks)}</Table.Td>
                  <Table.Td ta="right">{volume(vessel.volume_mm3)}</Table.Td>
                  <Table.Td ta="right">{area(vessel.area_mm2)}</Table.Td>
                </Table.Tr>
              );
            })}
          </Table.Tbody>
        </Table>
      </Table.ScrollContainer>
    </Structures>
  );
}
