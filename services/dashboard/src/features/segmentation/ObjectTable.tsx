import { Group, Progress, Table, Text, UnstyledButton } from "@mantine/core";
import { Fragment } from "react";
import { area, integer, percent, volume } from "@/format/format";
import type { SegmentedObject } from "./params";
import classes from "./segmentation.module.css";

interface ObjectTableProps {
  objects: readonly SegmentedObject[];
  mode: "tumor" | "object";
  chosen: number | null;
  onChoose: (label: number | null) => void;
}

export function ObjectTable({ objects, mode, chosen, onChoose }: ObjectTableProps) {
  return (
    <Table.ScrollContainer minWidth={560} type="native">
      <Table verticalSpacing="xs">
        <Table.Thead>
          <Table.Tr>
            <Table.Th>Object</Table.Th>
            <Table.Th ta="right">{mode === "object" ? "Volume" : "Enhancing"}</Table.Th>
            <Table.Th ta="right">{mode === "object" ? "With enclosed" : "Core"}</Table.Th>
            <Table.Th ta="right">Surface</Table.Th>
            <Table.Th w={150}>Confidence</Table.Th>
            <Table.Th>Mesh</Table.Th>
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {objects.map((object) => (
            <Fragment key={object.label}>
              <Table.Tr data-chosen={object.label === chosen || undefined} className={classes.object ?? ""}>
                <Table.Td>
                  <UnstyledButton
                    className={classes.pick ?? ""}
                    aria-pressed={object.label === chosen}
                    onClick={() => onChoose(object.label === chosen ? null : object.label)}
                  >
                    Object {object.label}
                  </UnstyledButton>
                </Table.Td>
                <Table.Td ta="right">{volume(object.volume_mm3)}</Table.Td>
                <Table.Td ta="right">{volume(object.core_volume_mm3)}</Table.Td>
                <Table.Td ta="right">{area(object.area_mm2)}</Table.Td>
                <Table.Td>
                  <Group gap="xs" wrap="nowrap">
                    <Progress value={object.confidence * 100} size="sm" flex={1} aria-label="Confidence" />
                    <Text size="sm">{percent(object.confidence)}</Text>
                  </Group>
                </Table.Td>
                <Table.Td>
                  <Text size="xs" c="dimmed">
                    {meshNote(object)}
                  </Text>
                </Table.Td>
              </Table.Tr>
              {object.notes?.map((note) => (
                <Table.Tr
                  key={note}
                  data-chosen={object.label === chosen || undefined}
                  className={classes.object ?? ""}
                >
                  <Table.Td colSpan={6} pt={0}>
                    <Text size="xs" c="dimmed">
                      {note}
                    </Text>
                  </Table.Td>
                </Table.Tr>
              ))}
            </Fragment>
          ))}
        </Table.Tbody>
      </Table>
    </Table.ScrollContainer>
  );
}

const POLARITIES = { dark: "darker than around", between: "between its surroundings" } as const;

function meshNote(object: SegmentedObject): string {
  const notes = [
    object.seeded_by === "user" ? "from your seed" : "",
    object.polarity === "bright" || object.polarity === undefined ? "" : POLARITIES[object.polarity],
    `${integer(object.faces)} faces`,
    object.closed ? "closed" : "open",
    object.genus === 0 ? "" : `genus ${object.genus}`,
    object.self_intersections === 0 ? "" : `${integer(object.self_intersections)} self-intersections`,
    object.converged ? "" : "not converged",
  ];
  return notes.filter(Boolean).join(", ");
}
