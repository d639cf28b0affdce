import { Link } from "@tanstack/react-router";
import { CircleAlert, Upload } from "lucide-react";
import { useStore } from "@/app/store";
import { percent } from "@/format/format";
import { uploads } from "./uploads";
import classes from "./uploads.module.css";

/** In the header of every page: how far the uploads are. */
export function UploadSummary() {
  const items = useStore(uploads.items);
  const stuck = items.filter((item) => item.state === "failed" || item.state === "needs-file").length;
  const open = items.filter((item) => item.state !== "done" && item.state !== "failed" && item.state !== "needs-file");
  if (open.length === 0 && stuck === 0) return null;
  const total = open.reduce((sum, item) => sum + item.size, 0);
  const sent = open.reduce((sum, item) => sum + item.sent, 0);
  return (
    <Link to="/upload" className={classes.summary}>
      {open.length > 0 ? (
        <>
          <Upload size={14} aria-hidden="true" />
          {open.length === 1 ? "1 upload" : `${open.length} uploads`} · {percent(total > 0 ? sent / total : 0)}
        </>
      ) : (
        <>
          <CircleAlert size={14} aria-hidden="true" />
          {stuck === 1 ? "1 upload needs you" : `${stuck} uploads need you`}
        </>
      )}
    </Link>
  );
}
