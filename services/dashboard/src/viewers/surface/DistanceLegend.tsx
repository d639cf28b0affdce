import { millimetres } from "@/format/format";
import { GRADIENT, type Spread } from "./scale";
import classes from "./surface.module.css";

/** What the colors of the distance to a reference mean. */
export function DistanceLegend({ spread }: { spread: Spread }) {
  return (
    <div className={classes.legend} data-testid="distances">
      <div>Distance to the mask&apos;s border</div>
      <div className={classes.scale} style={{ background: GRADIENT }} />
      <div className={classes.ends}>
        <span>{millimetres(spread.end)} inside</span>
        <span>0</span>
        <span>{millimetres(spread.end)} outside</span>
      </div>
      <div className={classes.told}>
        mean {millimetres(round(spread.mean))}, 95 % within {millimetres(round(spread.within95))}, at most{" "}
        {millimetres(round(spread.largest))}
      </div>
    </div>
  );
}

function round(value: number): number {
  return Number(value.toFixed(2));
}
