import { ActionIcon, Slider, Text } from "@mantine/core";
import { Pause, Play } from "lucide-react";
import { type ComponentProps, useMemo, useState } from "react";
import { calmed, type Store, useStore } from "@/app/store";
import classes from "./play.module.css";

interface PlayControlsProps {
  count: number;
  shown: number;
  playing: boolean;
  onPlaying: (playing: boolean) => void;
  /** Someone wants to see a frame; playing stops. */
  onFrame: (index: number) => void;
}

/** How often they follow what plays, in ms: a page that changes with each frame has less time to draw them. */
const FOLLOWS = 100;

/** The same for a frame that many are told of: nothing else is rendered anew for each. */
export function StoredControls({
  frame,
  ...others
}: { frame: Store<number> } & Omit<ComponentProps<typeof PlayControls>, "shown">) {
  const calm = useMemo(() => calmed(frame, FOLLOWS), [frame]);
  return <PlayControls shown={useStore(calm)} {...others} />;
}

/** Play, pause, and a slider over the frames, at the foot of a viewer. */
export function PlayControls({ count, shown, playing, onPlaying, onFrame }: PlayControlsProps) {
  // A frame is shown some time after it was asked for. Until then the slider stands where it was put, or the next key
  // would begin at the frame before.
  const [asked, setAsked] = useState<number | null>(null);
  if (asked === shown || (asked !== null && playing)) setAsked(null);
  return (
    <div className={classes.bar}>
      <ActionIcon
        variant="filled"
        size={32}
        radius="xl"
        aria-label={playing ? "Pause" : "Play"}
        disabled={count < 2}
        onClick={() => onPlaying(!playing)}
      >
        {playing ? <Pause size={16} /> : <Play size={16} />}
      </ActionIcon>
      <Slider
        className={classes.slider ?? ""}
        thumbLabel="Frame"
        label={null}
        size="sm"
        color="petrol.3"
        __vars={{ "--slider-track-bg": "#ffffff38" }} // on black, in both themes
        min={0}
        max={Math.max(count - 1, 1)}
        disabled={count < 2}
        value={asked ?? shown}
        onChange={(index) => {
          setAsked(index);
          onPlaying(false);
          onFrame(index);
        }}
      />
      <Text size="xs" c="gray.3" className={classes.place ?? ""} data-testid="frame">
        {shown + 1} / {count}
      </Text>
    </div>
  );
}
