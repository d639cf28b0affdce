import { Alert, createTheme, type MantineColorsTuple, Paper, Table } from "@mantine/core";

/** The one accent: petrol, the color of a surface in water. */
const petrol: MantineColorsTuple = [
  "#eaf6f5",
  "#d3eae8",
  "#a8d5d1",
  "#78bfba",
  "#4faaa5",
  "#2f9490",
  "#1b7f7d",
  "#11696b",
  "#0c5558",
  "#073f43",
];

/** Greys with a trace of the accent, so that the dark theme is calm rather than black. */
const dark: MantineColorsTuple = [
  "#d5dcdd",
  "#b4bdbf",
  "#8f9a9d",
  "#6a7679",
  "#465154",
  "#323b3e",
  "#252d30",
  "#1a2123",
  "#13191b",
  "#0d1213",
];

const gray: MantineColorsTuple = [
  "#f6f8f8",
  "#eff2f2",
  "#e3e8e8",
  "#d3dada",
  "#bac4c4",
  "#95a2a3",
  "#5c696b",
  "#4a5658",
  "#364244",
  "#1f292b",
];

export const theme = createTheme({
  primaryColor: "petrol",
  primaryShade: { light: 7, dark: 6 },
  colors: { petrol, dark, gray },
  autoContrast: true,
  luminanceThreshold: 0.35,
  fontFamily: '"Hanken Grotesk Variable", system-ui, sans-serif',
  fontFamilyMonospace: 'ui-monospace, "SF Mono", "Cascadia Mono", "DejaVu Sans Mono", monospace',
  headings: {
    fontWeight: "600",
    sizes: {
      h1: { fontSize: "1.5rem", lineHeight: "1.25" },
      h2: { fontSize: "1.125rem", lineHeight: "1.35" },
      h3: { fontSize: "0.9375rem", lineHeight: "1.4" },
    },
  },
  defaultRadius: "md",
  cursorType: "pointer",
  focusRing: "auto",
  respectReducedMotion: true,
  components: {
    Modal: { defaultProps: { closeButtonProps: { "aria-label": "Close" } } },
    Paper: Paper.extend({
      defaultProps: { withBorder: true, bg: "var(--card)" },
      styles: { root: { borderColor: "var(--line)" } },
    }),
    Table: Table.extend({ defaultProps: { borderColor: "var(--line)" } }),
    // The color stands in the line and the icon; the ground stays calm and the text readable in both themes.
    Alert: Alert.extend({
      vars: (_theme, { color = "petrol" }) => ({
        root: {
          "--alert-bg": `color-mix(in srgb, var(--mantine-color-${color}-6) 8%, var(--card))`,
          "--alert-bd": `1px solid color-mix(in srgb, var(--mantine-color-${color}-6) 40%, var(--line))`,
          "--alert-color": `light-dark(var(--mantine-color-${color}-8), var(--mantine-color-${color}-4))`,
        },
      }),
    }),
  },
});
