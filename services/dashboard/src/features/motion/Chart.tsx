import { Text } from "@mantine/core";
import classes from "./motion.module.css";

interface ChartProps {
  title: string;
  points: readonly { x: number; y: number }[];
  xLabel: string;
  yLabel: string;
  /** Written at the ends of the axes. */
  format: (value: number) => string;
  formatX?: (value: number) => string;
  /** Where one looks, in x. */
  at?: number | null;
  dots?: boolean;
}

const [WIDTH, HEIGHT] = [320, 110];

/** A small line chart; what it says is in its title and the ends of its axes. */
export function Chart({
  title,
  points,
  xLabel,
  yLabel,
  format,
  formatX = format,
  at = null,
  dots = false,
}: ChartProps) {
  if (points.length < 2) return null;
  const xs = points.map(({ x }) => x);
  const [left, right] = [Math.min(...xs), Math.max(...xs)];
  const top = Math.max(...points.map(({ y }) => y)) || 1;
  const px = (x: number) => ((x - left) / (right - left || 1)) * WIDTH;
  const py = (y: number) => HEIGHT - (y / top) * (HEIGHT - 6);
  return (
    <figure className={classes.chart}>
      <figcaption>
        <Text size="sm" fw={550}>
          {title}
        </Text>
        <Text size="xs" c="dimmed">
          {yLabel}, up to {format(top)}
        </Text>
      </figcaption>
      <svg
        viewBox={`0 0 ${WIDTH} ${HEIGHT}`}
        preserveAspectRatio="none"
        role="img"
        aria-label={`${title}: ${yLabel} up to ${format(top)}`}
      >
        {at !== null && at >= left && at <= right && (
          <line x1={px(at)} x2={px(at)} y1={0} y2={HEIGHT} className={classes.at} />
        )}
        <polyline points={points.map(({ x, y }) => `${px(x)},${py(y)}`).join(" ")} className={classes.line} />
        {dots &&
          points.map(({ x, y }) => <circle key={`${x} ${y}`} cx={px(x)} cy={py(y)} r={2.5} className={classes.dot} />)}
      </svg>
      <Text size="xs" c="dimmed" className={classes.axis ?? ""} component="div">
        <span>{formatX(left)}</span>
        <span>{xLabel}</span>
        <span>{formatX(right)}</span>
      </Text>
    </figure>
  );
}
