import { SegmentedControl } from "@mantine/core";
import { Waypoints } from "lucide-react";
import type { ReactNode } from "react";
import { Tool } from "@/viewers/Tool";

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
      <Tool
        label="Draw the graph of the parts"
        icon={Waypoints}
        on={graph}
        disabled={level === null}
        onClick={() => onGraph(!graph)}
      />
    </>
  );
}
