import { Button, NumberInput, Select, Slider, Stack, Switch, Text, Textarea, TextInput } from "@mantine/core";
import { type Choices, DEFAULTS } from "./params";

const POLARITIES: { value: Choices["polarity"]; label: string }[] = [
  { value: "auto", label: "As the data says" },
  { value: "bright", label: "Bright" },
  { value: "dark", label: "Dark" },
];
const BLEEDINGS: { value: Choices["microhemorrhages"]; label: string }[] = [
  { value: "auto", label: "Dark, where vessels are" },
  { value: "dark", label: "Dark" },
  { value: "bright", label: "Bright" },
  { value: "off", label: "Not looked for" },
];

interface AdvancedFieldsProps {
  choices: Choices;
  problems: Partial<Record<keyof Choices, string>>;
  /** Whether there is a volume that shows vessels. */
  withVessels: boolean;
  onChange: (change: Partial<Choices>) => void;
}

/** What a segmentation can be told beyond its volumes. */
export function AdvancedFields({ choices, problems, withVessels, onChange }: AdvancedFieldsProps) {
  return (
    <Stack gap="md">
      <Textarea
        label="Seed points"
        description={
          choices.mode === "object"
            ? "Points in the objects, RAS millimetres, one point to a line."
            : "RAS millimetres, one point to a line. Empty: seeds are found automatically."
        }
        placeholder="12.5, -30, 41"
        autosize
        minRows={2}
        maxRows={6}
        value={choices.seeds}
        error={problems.seeds}
        onChange={(event) => onChange({ seeds: event.currentTarget.value })}
      />
      {choices.mode !== "tumor" && (
        <TextInput
          label="Box"
          description="Two opposite corners that the object lies between, RAS millimetres."
          placeholder="-10, 0, 20, 30, 45, 60"
          value={choices.box}
          error={problems.box}
          onChange={(event) => onChange({ box: event.currentTarget.value })}
        />
      )}
      {withVessels && (
        <>
          <Select
            label="Vessels are"
            description="Dark in SWI; bright in MRA, time-of-flight and CTA."
            data={POLARITIES}
            allowDeselect={false}
            value={choices.polarity}
            onChange={(value) => onChange({ polarity: value ?? "auto" })}
          />
          <Textarea
            label="Seed points in vessels"
            description="RAS millimetres. Empty: they are found around what is segmented."
            autosize
            minRows={1}
            maxRows={6}
            value={choices.vesselSeeds}
            error={problems.vesselSeeds}
            onChange={(event) => onChange({ vesselSeeds: event.currentTarget.value })}
          />
          <Select
            label="Bleedings are"
            data={BLEEDINGS}
            allowDeselect={false}
            value={choices.microhemorrhages}
            onChange={(value) => onChange({ microhemorrhages: value ?? "auto" })}
          />
        </>
      )}
      <Switch
        label="Move volumes that lie elsewhere onto the first"
        checked={choices.register}
        onChange={(event) => onChange({ register: event.currentTarget.checked })}
      />
      <NumberInput
        label="Objects at the most"
        min={1}
        max={64}
        allowDecimal={false}
        value={choices.maxObjects}
        onChange={(value) => onChange({ maxObjects: typeof value === "number" ? value : "" })}
      />
      <Select
        label="Topology"
        description="Whether the surface may merge where it meets itself, or keeps its genus and a seam."
        data={[
          { value: "adaptive", label: "Adaptive" },
          { value: "preserve", label: "Preserve" },
        ]}
        allowDeselect={false}
        value={choices.topology}
        onChange={(value) => onChange({ topology: value ?? "adaptive" })}
      />
      <NumberInput
        label="Edge length of the mesh"
        description="Empty: chosen from the voxels' spacing."
        suffix=" mm"
        min={0.1}
        max={50}
        step={0.1}
        decimalScale={2}
        value={choices.edgeLength}
        onChange={(value) => onChange({ edgeLength: typeof value === "number" ? value : "" })}
      />
      <div>
        <Text size="sm" fw={500}>
          Smoothing
        </Text>
        <Slider
          thumbLabel="Smoothing"
          min={0}
          max={1}
          step={0.01}
          marks={[{ value: DEFAULTS.smoothing }]}
          value={choices.smoothing}
          onChange={(value) => onChange({ smoothing: value })}
        />
      </div>
      <NumberInput
        label="Random seed"
        min={0}
        max={2 ** 32 - 1}
        allowDecimal={false}
        value={choices.randomSeed}
        onChange={(value) => onChange({ randomSeed: typeof value === "number" ? value : "" })}
      />
      <Button
        variant="subtle"
        color="gray"
        size="compact-sm"
        w="fit-content"
        onClick={() => onChange({ ...DEFAULTS, mode: choices.mode })}
      >
        Back to the defaults
      </Button>
    </Stack>
  );
}
