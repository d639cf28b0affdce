import { Alert, Button, Center, Loader, Progress, Stack, Text } from "@mantine/core";
import { MonitorX, RotateCw } from "lucide-react";
import type { ReactNode } from "react";
import { describe } from "@/api/problem";
import classes from "./viewers.module.css";

export type ViewerStatus =
  /** `fraction` of what it waits for is here; null where nobody knows. */
  | { is: "loading"; fraction: number | null; what: string }
  | { is: "ready" }
  | { is: "failed"; error: unknown }
  /** The graphics driver took the picture away. */
  | { is: "lost" };

interface ViewerFrameProps {
  label: string;
  status: ViewerStatus;
  onRetry: () => void;
  /** Beside the title. */
  tools: ReactNode;
  children?: ReactNode;
}

/** Around a drawing: what it waits for, or why it is not there. */
export function ViewerFrame({ label, status, onRetry, tools, children }: ViewerFrameProps) {
  return (
    <section className={classes.frame} aria-label={label} data-status={status.is}>
      <header className={classes.bar}>
        <span className={classes.title}>{label}</span>
        {status.is === "ready" && tools}
      </header>
      <div className={classes.body}>
        {children}
        {status.is === "loading" && (
          <Center className={classes.veil ?? ""} role="status">
            <Stack gap="xs" w={220}>
              <Text size="sm" c="gray.4" ta="center">
                {status.what}
              </Text>
              {status.fraction === null ? (
                <Loader size="sm" type="dots" mx="auto" color="petrol.3" />
              ) : (
                <Progress
                  value={status.fraction * 100}
                  size="xs"
                  color="petrol.3"
                  bg="#ffffff30"
                  aria-label={status.what}
                />
              )}
            </Stack>
          </Center>
        )}
        {(status.is === "failed" || status.is === "lost") && (
          <Center className={classes.veil ?? ""} p="lg">
            <Stack align="center" gap="sm" maw={360} role="alert">
              <Text size="sm" c="gray.3" ta="center">
                {status.is === "lost"
                  ? "The graphics driver has dropped this picture."
                  : `This cannot be drawn: ${describe(status.error).message} ${describe(status.error).hint}`}
              </Text>
              <Button size="xs" variant="default" leftSection={<RotateCw size={14} />} onClick={onRetry}>
                Draw it again
              </Button>
            </Stack>
          </Center>
        )}
      </div>
    </section>
  );
}

/** In the place of a viewer whose program, or whose file, is still on its way. */
export function ViewerComing({ label, what = "Loading the viewer…" }: { label: string; what?: string }) {
  return (
    <ViewerFrame
      label={label}
      status={{ is: "loading", fraction: null, what }}
      tools={null}
      onRetry={() => undefined}
    />
  );
}

/** In the place of a drawing that this browser cannot make; `children` are what can be shown all the same. */
export function NoWebGL({ children }: { children?: ReactNode }) {
  return (
    <Alert
      color="orange"
      variant="light"
      icon={<MonitorX size={18} />}
      title={
        <Text span inherit c="var(--mantine-color-text)">
          This browser cannot draw in 3D
        </Text>
      }
      role="alert"
    >
      <Stack gap="md">
        <Text size="sm">
          WebGL 2 is switched off or missing. Switch on hardware acceleration in the browser's settings, or open this
          page in a current Firefox, Chrome, Edge or Safari. Everything else on this page works without it.
        </Text>
        {children}
      </Stack>
    </Alert>
  );
}
