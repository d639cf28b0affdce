import { Paper, Table, Text, Title } from "@mantine/core";
import { millimetres, significant } from "@/format/format";
import type { SegmentationResult } from "./params";

const INPUTS: Record<string, string> = { pre: "Before contrast", vessels: "Vessels" };

/** Where the other volumes lay, seen from the one after contrast. */
export function Alignments({ result }: { result: SegmentationResult }) {
  const alignments = result.alignments ?? [];
  if (alignments.length === 0) return null;
  return (
    <Paper p="md" component="section" aria-labelledby="alignments">
      <Title order={3} id="alignments" mb="xs">
        Alignment
      </Title>
      <Table verticalSpacing={4} horizontalSpacing={6} fz="sm">
        <Table.Thead>
          <Table.Tr>
            <Table.Th>Volume</Table.Th>
            <Table.Th ta="right">Moved</Table.Th>
            <Table.Th ta="right">Turned</Table.Th>
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {alignments.map((one) => (
            <Table.Tr key={one.input}>
              <Table.Td>
                {INPUTS[one.input] ?? one.input}
                <Text size="xs" c="dimmed">
                  {one.moved
                    ? `mutual information ${significant(one.mutual_information_before, 3)} → ${significant(one.mutual_information, 3)}`
                    : `lay there; mutual information ${significant(one.mutual_information, 3)}`}
                </Text>
              </Table.Td>
              <Table.Td ta="right">{one.moved ? millimetres(one.shift_mm) : "–"}</Table.Td>
              <Table.Td ta="right">{one.moved ? `${significant(one.degrees, 3)}°` : "–"}</Table.Td>
            </Table.Tr>
          ))}
        </Table.Tbody>
      </Table>
    </Paper>
  );
}
