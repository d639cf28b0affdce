"""The codec of the dissertation: clusters of deformation gradients, glued by a Poisson system (section 5.4)."""
