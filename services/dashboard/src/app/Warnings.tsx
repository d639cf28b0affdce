import { Alert, Stack, Text } from "@mantine/core";
import { TriangleAlert } from "lucide-react";

/** What somebody should know who uses a result. */
export function Warnings({ of }: { of: readonly string[] | undefined }) {
  if (!of || of.length === 0) return null;
  return (
    <Alert color="yellow" variant="light" icon={<TriangleAlert size={18} />}>
      <Stack gap={6}>
        {of.map((warning) => (
          <Text key={warning} size="sm">
            {warning}
          </Text>
        ))}
      </Stack>
    </Alert>
  );
}
