import { Progress, Text } from "@mantine/core";
import type { Batch } from "@/api/types";
import { count, ended, standing, troubled } from "./naming";

/** A batch as one bar: done, failed, cancelled, running; what is left empty waits. */
export function BatchProgress({ batch, large = false }: { batch: Batch; large?: boolean }) {
  const share = (jobs: number) => (100 * jobs) / Math.max(batch.total, 1);
  const says = standing(batch);
  const parts: [string, number][] = [
    ["teal", count(batch, "succeeded")],
    ["red", troubled(batch)],
    ["gray", count(batch, "cancelled")],
    ["blue", count(batch, "running", "cancelling")],
  ];
  return (
    <>
      <Text size="sm" mb={6} aria-live={large ? "polite" : "off"} data-testid="standing">
        {says}
      </Text>
      <Progress.Root
        size={large ? "lg" : "sm"}
        role="progressbar"
        aria-label={says}
        aria-valuemin={0}
        aria-valuemax={batch.total}
        aria-valuenow={ended(batch)}
      >
        {parts
          .filter(([, jobs]) => jobs > 0)
          .map(([color, jobs]) => (
            <Progress.Section
              key={color}
              value={share(jobs)}
              color={color}
              withAria={false}
              animated={color === "blue"}
            />
          ))}
      </Progress.Root>
    </>
  );
}
