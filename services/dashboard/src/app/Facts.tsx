import type { ReactNode } from "react";
import classes from "./Facts.module.css";

interface FactsProps {
  rows: readonly (readonly [name: string, value: ReactNode])[];
  /** Where values are: at the right end of the line, beside their names, or below them in as many columns as fit. */
  values?: "end" | "beside" | "below";
}

/** Names and values. */
export function Facts({ rows, values = "end" }: FactsProps) {
  return (
    <dl className={classes.facts} data-values={values}>
      {rows.map(([name, value]) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd>{value}</dd>
        </div>
      ))}
    </dl>
  );
}
