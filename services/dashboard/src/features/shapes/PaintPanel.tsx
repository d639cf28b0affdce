import { Button, Group, Paper, SegmentedControl, Slider, Stack, Text, Title } from "@mantine/core";
import { Search } from "lucide-react";
import { LinkButton } from "@/app/links";
import { percent } from "@/format/format";
import { cssColor, partColor } from "@/viewers/shape/colors";
import type { ShapeModel } from "@/viewers/shape/model";
import { writeParts } from "./searching";
import classes from "./shape.module.css";
import { finest, type Painting } from "./usePainting";

interface PaintPanelProps {
  model: ShapeModel;
  painting: Painting;
  /** What the search begins with besides the parts. */
  search: Record<string, unknown>;
  onClose: () => void;
}

/** The brush, how much is painted, and the search with it. */
export function PaintPanel({ model, painting, search, onClose }: PaintPanelProps) {
  const { painted, radius, erase } = painting;
  const parts = model.parts(finest(model));
  const there = parts ? [...new Set(parts)].sort((one, other) => one - other) : [];
  return (
    <Paper p="md" component="section" aria-label="Paint a region">
      <Stack gap="sm">
        <Group justify="space-between">
          <Title order={3}>Paint a region</Title>
          <Button size="compact-sm" variant="subtle" color="gray" onClick={onClose}>
            Close
          </Button>
        </Group>
        <Text size="sm" c="dimmed">
          Drag on the shape to paint, beside it to turn it.
        </Text>
        <Group gap="md" wrap="nowrap">
          <SegmentedControl
            size="xs"
            aria-label="What dragging does"
            data={[
              { value: "paint", label: "Paint" },
              { value: "erase", label: "Erase" },
            ]}
            value={erase ? "erase" : "paint"}
            onChange={(value) => painting.setErase(value === "erase")}
          />
          <Slider
            style={{ flex: 1 }}
            thumbLabel="Size of the brush"
            label={null}
            size="sm"
            min={0.03}
            max={0.5}
            step={0.01}
            value={radius}
            onChange={painting.setRadius}
          />
        </Group>
        <div role="group" aria-label="Parts of the shape" className={classes.chips}>
          {there.map((part) => (
            <button
              key={part}
              type="button"
              className={classes.chip}
              aria-pressed={painted.parts.includes(part)}
              aria-label={`Part ${part + 1}`}
              onClick={() => painting.toggle(part)}
            >
              <span style={{ background: cssColor(partColor(part)) }} />
              {part + 1}
            </button>
          ))}
        </div>
        <Text size="sm" aria-live="polite" data-testid="painted">
          {painted.parts.length === 0
            ? "Nothing is painted yet."
            : `${percent(painted.share)} of the area painted: the search takes ${painted.parts.length} of ${there.length} parts, ${percent(painted.used)}.`}
        </Text>
        <Group gap="sm">
          {painted.parts.length > 0 ? (
            <LinkButton
              to="/shapes/search"
              search={{ ...search, parts: writeParts(painted.parts) }}
              leftSection={<Search size={15} aria-hidden="true" />}
              size="sm"
            >
              Find this region
            </LinkButton>
          ) : (
            <Button size="sm" disabled leftSection={<Search size={15} aria-hidden="true" />}>
              Find this region
            </Button>
          )}
          <Button size="sm" variant="default" disabled={painted.share === 0} onClick={painting.clear}>
            Clear
          </Button>
        </Group>
      </Stack>
    </Paper>
  );
}
