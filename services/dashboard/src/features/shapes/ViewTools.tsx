import { ActionIcon, SegmentedControl, Tooltip } from "@mantine/core";
import { Waypoints } from "lucide-react";
import type { ReactNode } from "react";

interface ViewToolsProps {
  levels: readonly { level: number; parts: number }[];
  /** Whose parts are colored; null for none. */
  level: number | null;
  onLevel: (level: number | null) => void;
  graph: boolean;
  onGraph: (on: boolean) => void;
  children?: ReactNode;
}

/** Which level of parts is shown, and whether the graph is. */
export function ViewTools({ levels, level, onLevel, graph, onGraph, children }: ViewToolsProps) {
  return (
    <>
      {children}
      <SegmentedControl
        size="xs"
        aria-label="Parts shown"
        data={[
          { value: "none", label: "Plain" },
          ...levels.map((one) => ({ value: String(one.level), label: `${one.parts} parts` })),
        ]}
        value={level === null ? "none" : String(level)}
        onChange={(value) => onLevel(value === "none" ? null : Number(value))}
      />
      <Tooltip label="Draw the graph of the parts" openDelay={400}>
        <ActionIcon
          variant={graph ? "filled" : "default"}
          size={30}
          aria-label="Draw the graph of the parts"
          aria-pressed={graph}
          disabled={level === null}
          onClick={() => onGraph(!graph)}
        >
          <Waypoints size={16} />
        </ActionIcon>
      </Tooltip>
    </>
  );
}
