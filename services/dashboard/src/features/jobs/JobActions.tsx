import { Button } from "@mantine/core";
import { RotateCcw, X } from "lucide-react";
import { useJobAction } from "@/api/queries";
import { canCancel, canRetry, type Job } from "@/api/types";
import { sayFailure } from "@/app/say";

/** Cancel or retry, whichever the job's state allows. */
export function JobActions({ job, name, compact = false }: { job: Job; name: string; compact?: boolean }) {
  const act = useJobAction();
  const run = (action: "cancel" | "retry") =>
    act.mutate(
      { id: job.id, action },
      {
        onError: (error) => sayFailure(action === "cancel" ? "Not cancelled" : "Not started again", error),
      },
    );
  const size = compact ? "compact-sm" : "sm";
  if (canCancel(job.state)) {
    return (
      <Button
        size={size}
        variant="default"
        leftSection={<X size={14} aria-hidden="true" />}
        loading={act.isPending}
        aria-label={`Cancel ${name}`}
        onClick={() => run("cancel")}
      >
        Cancel
      </Button>
    );
  }
  if (canRetry(job.state)) {
    return (
      <Button
        size={size}
        variant="default"
        leftSection={<RotateCcw size={14} aria-hidden="true" />}
        loading={act.isPending}
        aria-label={`Retry ${name}`}
        onClick={() => run("retry")}
      >
        Retry
      </Button>
    );
  }
  return null;
}
