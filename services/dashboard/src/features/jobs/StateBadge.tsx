import { Badge, Tooltip } from "@mantine/core";
import { Ban, CircleCheck, CircleX, Clock, type LucideIcon, OctagonAlert, Play, Square } from "lucide-react";
import type { JobState } from "@/api/types";

interface Look {
  color: string;
  icon: LucideIcon;
  says: string;
}

/** State is told by word, icon and color together, never by color alone. */
const LOOKS: Record<JobState, Look> = {
  queued: { color: "gray", icon: Clock, says: "Waits for a free worker." },
  running: { color: "blue", icon: Play, says: "A worker is at it." },
  cancelling: {
    color: "orange",
    icon: Square,
    says: "Its worker is being stopped.",
  },
  succeeded: {
    color: "teal",
    icon: CircleCheck,
    says: "The results are there.",
  },
  failed: {
    color: "red",
    icon: CircleX,
    says: "Something about the input or the parameters has to be mended.",
  },
  crashed: {
    color: "grape",
    icon: OctagonAlert,
    says: "The fault is on the server's side; it was logged.",
  },
  cancelled: { color: "gray", icon: Ban, says: "It was called off." },
};

export function StateBadge({ state }: { state: JobState }) {
  const { color, icon: Icon, says } = LOOKS[state];
  return (
    <Tooltip label={says} openDelay={300}>
      <Badge
        variant="light"
        color={color}
        tt="none"
        size="md"
        leftSection={<Icon size={12} strokeWidth={2.5} aria-hidden="true" />}
        data-state={state}
        styles={{
          root: {
            flexShrink: 0,
            background: `color-mix(in srgb, var(--mantine-color-${color}-6) 14%, var(--card))`,
          },
          label: {
            color: `light-dark(color-mix(in srgb, var(--mantine-color-${color}-9) 80%, black), var(--mantine-color-${color}-2))`,
            fontWeight: 600,
          },
        }}
      >
        {state}
      </Badge>
    </Tooltip>
  );
}
