import { Tooltip } from "@mantine/core";
import type { SearchHit } from "@/api/types";
import { ShapePicture } from "./ShapePicture";
import classes from "./shape.module.css";

interface HitListProps {
  hits: readonly SearchHit[];
  partial: boolean;
  chosen: string | null;
  onChoose: (id: string) => void;
}

/** What was found, best first; the chosen one is shown beside the query. */
export function HitList({ hits, partial, chosen, onChoose }: HitListProps) {
  return (
    <ol className={classes.hits} aria-label="Found shapes, best first">
      {hits.map((hit, index) => (
        <li key={hit.shape_id} data-hit={hit.shape.name}>
          <Tooltip label={scores(hit, partial)} openDelay={600} position="left" multiline maw={260}>
            <button
              type="button"
              className={classes.hit}
              aria-pressed={hit.shape_id === chosen}
              onClick={() => onChoose(hit.shape_id)}
            >
              <ShapePicture shape={hit.shape} size={68} />
              <span style={{ minWidth: 0 }}>
                <span className={classes.title}>
                  {index + 1}. {hit.shape.name || "Without a name"}
                </span>
                <span className={classes.score}>
                  {hit.score.toFixed(2)}
                  <span className={classes.bar} aria-hidden="true">
                    <span style={{ width: `${100 * hit.score}%` }} />
                  </span>
                </span>
                <span className={classes.small}>{best(hit)}</span>
              </span>
            </button>
          </Tooltip>
        </li>
      ))}
    </ol>
  );
}

/** The level that fits best, in words. */
export function best({ level }: Pick<SearchHit, "level">): string {
  return level === 0 ? "the whole" : `level ${level}, ${level === 1 ? "coarse" : "fine"} parts`;
}

/** Parts are compared without the whole. */
function scores({ level_scores }: SearchHit, partial: boolean): string {
  const told = level_scores.map((score, place) => {
    const level = partial ? place + 1 : place;
    return `${level === 0 ? "whole" : `level ${level}`} ${score.toFixed(2)}`;
  });
  return `Scores: ${told.join(", ")}`;
}
