import { ButtonLink } from "@/components/controls/Button";
import { Empty } from "@/components/feedback/States";

/** Shown for an unknown address. */
export function NotFound() {
  return (
    <Empty title="Page not found" actions={<ButtonLink to="/">All behaviours</ButtonLink>}>
      <p>The address is wrong, or what was here has been deleted.</p>
    </Empty>
  );
}
