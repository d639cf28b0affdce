import { Check } from "lucide-react";
import classes from "./jobs.module.css";

/** The way a job takes: what is behind it, where it is, what lies ahead. */
export function StagePath({ stages, current }: { stages: readonly string[]; current: string }) {
  const at = stages.indexOf(current);
  return (
    <ol className={classes.path} aria-label="Stages">
      {stages.map((stage, index) => {
        const is = at < 0 || index > at ? "ahead" : index < at ? "done" : "now";
        return (
          <li key={stage} className={classes.stage} data-is={is} aria-current={is === "now" ? "step" : undefined}>
            <span className={classes.dot} aria-hidden="true">
              {is === "done" && <Check size={12} strokeWidth={3} />}
            </span>
            {stage.charAt(0).toUpperCase() + stage.slice(1)}
          </li>
        );
      })}
    </ol>
  );
}
