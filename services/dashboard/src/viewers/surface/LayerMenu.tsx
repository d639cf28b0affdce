import { ActionIcon, Popover, Slider, Stack, Text, Tooltip } from "@mantine/core";
import { Layers } from "lucide-react";
import type { SurfaceFile } from "./surfaceFile";

/** Opacity by group, in [0, 1]; 1 where nothing is said. */
export type Opacities = Readonly<Record<string, number>>;

interface LayerMenuProps {
  surfaces: readonly SurfaceFile[];
  opacities: Opacities;
  onChange: (opacities: Opacities) => void;
}

/** How much of each group of surfaces is seen. */
export function LayerMenu({ surfaces, opacities, onChange }: LayerMenuProps) {
  const groups = [...new Set(surfaces.map(({ group }) => group))];
  return (
    <Popover position="bottom-end" width={220} trapFocus shadow="md">
      <Popover.Target>
        <Tooltip label="Layers" openDelay={400}>
          <ActionIcon variant="default" size={30} aria-label="Layers">
            <Layers size={16} />
          </ActionIcon>
        </Tooltip>
      </Popover.Target>
      <Popover.Dropdown>
        <Stack gap="sm">
          {groups.map((group) => (
            <div key={group}>
              <Text size="sm" fw={500}>
                {group}
              </Text>
              <Slider
                thumbLabel={`Opacity: ${group}`}
                size="sm"
                min={0}
                max={1}
                step={0.05}
                label={(value) => `${Math.round(value * 100)} %`}
                value={opacities[group] ?? 1}
                onChange={(opacity) => onChange({ ...opacities, [group]: opacity })}
              />
            </div>
          ))}
        </Stack>
      </Popover.Dropdown>
    </Popover>
  );
}
