/** A number and its unit stay on one line. */
const SPACE = "\u00A0";
const THIN_SPACE = "\u202F";

/** 1536 → "1.5 kB", in powers of 1000 as disks and networks count. */
export function bytes(count: number): string {
  if (!Number.isFinite(count) || count < 0) return "–";
  if (count < 1000) return `${count}${SPACE}B`;
  const units = ["kB", "MB", "GB", "TB"];
  let value = count;
  let unit = -1;
  do {
    value /= 1000;
    unit += 1;
  } while (unit < units.length - 1 && Number(value.toPrecision(3)) >= 1000);
  return `${significant(value, 3)}${SPACE}${units[unit]}`;
}

/** At most `digits` significant figures, without an exponent or trailing zeros. */
export function significant(value: number, digits: number): string {
  if (!Number.isFinite(value)) return "–";
  return Number(value.toPrecision(digits)).toLocaleString("en", {
    maximumFractionDigits: 12,
    useGrouping: false,
  });
}

/** Grouped by thousands: 12 345. */
export function integer(value: number): string {
  return Math.round(value).toLocaleString("en").replaceAll(",", THIN_SPACE);
}

/** A volume given in mm³, in the unit that is read with ease. */
export function volume(mm3: number): string {
  return Math.abs(mm3) >= 1000 ? `${significant(mm3 / 1000, 3)}${SPACE}cm³` : `${significant(mm3, 3)}${SPACE}mm³`;
}

/** An area given in mm². */
export function area(mm2: number): string {
  return Math.abs(mm2) >= 1000 ? `${significant(mm2 / 100, 3)}${SPACE}cm²` : `${significant(mm2, 3)}${SPACE}mm²`;
}

/** A length given in mm: "0.84 mm", "187 mm". */
export function millimetres(mm: number): string {
  return `${significant(mm, 3)}${SPACE}mm`;
}

/** 0.937 → "94 %"; never 100 % for less than all. */
export function percent(fraction: number): string {
  const clamped = Math.min(Math.max(fraction, 0), 1);
  const rounded = clamped < 1 ? Math.min(99, Math.round(clamped * 100)) : 100;
  return `${rounded}${SPACE}%`;
}

/** A duration in seconds: "0.4 s", "12 s", "3 min 05 s", "30 min", "2 h 10 min". */
export function duration(seconds: number): string {
  if (!Number.isFinite(seconds) || seconds < 0) return "–";
  if (seconds < 9.95) return `${seconds.toFixed(1)}${SPACE}s`;
  const whole = Math.round(seconds);
  if (whole < 60) return `${whole}${SPACE}s`;
  const minutes = Math.floor(whole / 60);
  if (minutes < 60) {
    const rest = whole % 60 === 0 ? "" : `${SPACE}${String(whole % 60).padStart(2, "0")}${SPACE}s`;
    return `${minutes}${SPACE}min${rest}`;
  }
  const rest = minutes % 60 === 0 ? "" : `${SPACE}${minutes % 60}${SPACE}min`;
  return `${Math.floor(minutes / 60)}${SPACE}h${rest}`;
}

const STEPS: readonly [Intl.RelativeTimeFormatUnit, number][] = [
  ["day", 86_400],
  ["hour", 3_600],
  ["minute", 60],
];

/** "5 minutes ago", "in 29 days"; `at` and `now` in milliseconds. */
export function relative(at: number, now: number): string {
  const seconds = (at - now) / 1000;
  for (const [unit, length] of STEPS) {
    if (Math.abs(seconds) >= length) {
      return new Intl.RelativeTimeFormat("en").format(Math.trunc(seconds / length), unit);
    }
  }
  return seconds > 0 ? "in less than a minute" : "just now";
}

/** How long ago something was; a server whose clock is a little ahead does not put it into the future. */
export function ago(at: string, now: number): string {
  return relative(Math.min(Date.parse(at), now), now);
}

/** A moment in the reader's own time zone: "22 Nov 2026, 19:30". */
export function moment(at: string): string {
  return new Date(at).toLocaleString("en-GB", {
    dateStyle: "medium",
    timeStyle: "short",
  });
}

/** [240, 240, 155] → "240 × 240 × 155". */
export function shape(extent: readonly number[]): string {
  return extent.join(" × ");
}

/** A point in RAS mm as anatomists say it: "R 12.0 · A 3.5 · S 40.2". */
export function anatomical([x, y, z]: readonly [number, number, number]): string {
  const part = (value: number, plus: string, minus: string) =>
    `${value >= 0 ? plus : minus}${SPACE}${Math.abs(value).toFixed(1)}`;
  return [part(x, "R", "L"), part(y, "A", "P"), part(z, "S", "I")].join("   ");
}

/** "queued" → "Queued". */
export function capital(word: string): string {
  return word.charAt(0).toUpperCase() + word.slice(1);
}
