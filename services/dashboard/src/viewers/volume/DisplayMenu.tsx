import {
  ActionIcon,
  ColorSwatch,
  Group,
  Popover,
  RangeSlider,
  Slider,
  Stack,
  Switch,
  Text,
  Tooltip,
} from "@mantine/core";
import { SlidersHorizontal } from "lucide-react";
import { significant } from "@/format/format";
import { type LabelNames, LABELS } from "../labels";
import type { Display } from "./VolumeCanvas";

interface DisplayMenuProps {
  display: Display;
  /** Intensities from the darkest to the brightest. */
  range: [number, number];
  hasLabels: boolean;
  hasReference: boolean;
  /** Labels that occur, and their names. */
  present: readonly number[];
  names: LabelNames;
  onChange: (change: Partial<Display>) => void;
}

/** How the picture is drawn: the labels' opacity, the window, the side one looks from. */
export function DisplayMenu({ display, range, hasLabels, hasReference, present, names, onChange }: DisplayMenuProps) {
  const step = (range[1] - range[0]) / 200 || 0.01;
  return (
    <Popover position="bottom-end" width={290} trapFocus shadow="md">
      <Popover.Target>
        <Tooltip label="Overlay and window" openDelay={400}>
          <ActionIcon variant="default" size={30} aria-label="Overlay and window">
            <SlidersHorizontal size={16} />
          </ActionIcon>
        </Tooltip>
      </Popover.Target>
      <Popover.Dropdown>
        <Stack gap="sm">
          {display.layout === "render" && (
            <div>
              <Text size="sm" fw={500}>
                Opacity of the volume
              </Text>
              <Slider
                thumbLabel="Opacity of the volume"
                size="sm"
                min={0}
                max={1}
                step={0.05}
                label={(value) => `${Math.round(value * 100)} %`}
                value={display.volumeOpacity}
                onChange={(volumeOpacity) => onChange({ volumeOpacity })}
              />
            </div>
          )}
          {hasLabels && (
            <>
              <div>
                <Text size="sm" fw={500}>
                  Opacity of the labels
                </Text>
                <Slider
                  thumbLabel="Opacity of the labels"
                  size="sm"
                  min={0}
                  max={1}
                  step={0.05}
                  label={(value) => `${Math.round(value * 100)} %`}
                  value={display.opacity}
                  onChange={(opacity) => onChange({ opacity })}
                />
              </div>
              {present.length > 1 &&
                present.map((value) => (
                  <Group key={value} gap="xs" wrap="nowrap">
                    <ColorSwatch
                      size={12}
                      radius={3}
                      withShadow={false}
                      color={LABELS.find((label) => label.value === value)?.color ?? "gray"}
                    />
                    <Text size="xs" w={112}>
                      {names[value]}
                    </Text>
                    <Slider
                      flex={1}
                      thumbLabel={`Opacity: ${names[value]}`}
                      size="xs"
                      min={0}
                      max={1}
                      step={0.05}
                      label={(opacity) => `${Math.round(opacity * 100)} %`}
                      value={display.layers[value] ?? 1}
                      onChange={(opacity) => onChange({ layers: { ...display.layers, [value]: opacity } })}
                    />
                  </Group>
                ))}
              <Switch
                size="sm"
                label="Outlines only"
                checked={display.outline}
                onChange={(event) => onChange({ outline: event.currentTarget.checked })}
              />
            </>
          )}
          {hasReference && (
            <div>
              <Text size="sm" fw={500}>
                Opacity of the reference
              </Text>
              <Slider
                thumbLabel="Opacity of the reference"
                size="sm"
                min={0}
                max={1}
                step={0.05}
                label={(value) => `${Math.round(value * 100)} %`}
                value={display.referenceOpacity}
                onChange={(referenceOpacity) => onChange({ referenceOpacity })}
              />
            </div>
          )}
          <div>
            <Text size="sm" fw={500}>
              Window: black and white at
            </Text>
            <RangeSlider
              size="sm"
              thumbFromLabel="Black at"
              thumbToLabel="White at"
              min={range[0]}
              max={range[1]}
              step={step}
              minRange={step}
              label={(value) => significant(value, 3)}
              value={display.window}
              onChange={(window) => onChange({ window })}
            />
          </div>
          <Switch
            size="sm"
            label="Patient's left on the right"
            checked={display.radiological}
            onChange={(event) => onChange({ radiological: event.currentTarget.checked })}
          />
        </Stack>
      </Popover.Dropdown>
    </Popover>
  );
}
